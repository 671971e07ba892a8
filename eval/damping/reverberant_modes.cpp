#include "eval/damping/reverberant_modes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "eval/damping/detail/reverberant_line.hpp"
#include "eval/features/segment.hpp"
#include "synth/signal/real_fft.hpp"

namespace carillon::eval::damping {

namespace {

constexpr double above_floor = 30;                ///< power of a peak against the median about it
constexpr double floor_width = 500;               ///< in which that median is taken [Hz]
constexpr double min_line_level = 100;            ///< power of a line at its begin over the noise
constexpr double max_whiteness = 11.2;            ///< one in a thousand of single modes has more
constexpr double band_rates[] = {400, 200, 100};  ///< [1/s]
constexpr double max_relative_error = 0.2;        ///< of a decay rate, by the likelihood
/// What errors are beyond those of the likelihood: its factor, and a fraction of d.
constexpr double model_factor = 1.5, model_error = 0.02;
constexpr std::size_t max_tries = 300;
constexpr double longest = 40;            ///< time that is looked at, by the room's decay rate
constexpr std::size_t floor_bins = 1000;  ///< of which the median is taken, at most about

/// A peak of a spectrum.
struct Peak {
  double frequency = 0;  ///< [Hz]
  double power = 0;
  std::size_t bin = 0;
};

/// Median of a spectrum about a bin, of every so many bins.
double floor_at(std::span<const double> power, std::size_t bin, std::size_t about) {
  const std::size_t step = std::max<std::size_t>(1, 2 * about / floor_bins);
  std::vector<double> values;
  for (std::size_t k = bin - std::min(bin, about); k < std::min(power.size(), bin + about + 1);
       k += step) {
    values.push_back(power[k]);
  }
  return core::median(values);
}

/// Peaks of the spectrum of t exp(-delta t) times the sound, by power, descending. The window takes
/// what is late, where the room's noise splits lines, and the edge at the begin, whose skirts would
/// hide weak lines.
std::vector<Peak> spectrum_peaks(std::span<const double> sound, double sample_rate,
                                 double room_rate, const ReverberantOptions& options) {
  synth::signal::RealFft fft(synth::signal::good_fft_size(2 * sound.size()));
  std::fill(fft.signal().begin(), fft.signal().end(), 0.0);
  for (std::size_t n = 0; n < sound.size(); ++n) {
    const double t = static_cast<double>(n) / sample_rate;
    fft.signal()[n] = sound[n] * t * std::exp(-room_rate * t);
  }
  fft.forward();
  std::vector<double> power(fft.bins());
  for (std::size_t k = 0; k < power.size(); ++k) power[k] = std::norm(fft.spectrum()[k]);
  const double bin = sample_rate / static_cast<double>(fft.size());
  const auto about = std::max<std::size_t>(1, static_cast<std::size_t>(floor_width / 2 / bin));
  std::vector<Peak> peaks;
  double highest = 0;
  for (std::size_t k = 1; k + 1 < power.size(); ++k) {
    const double frequency = static_cast<double>(k) * bin;
    if (frequency < options.min_frequency || frequency > options.max_frequency) continue;
    if (power[k] < power[k - 1] || power[k] <= power[k + 1]) continue;
    peaks.push_back({frequency, power[k], k});
    highest = std::max(highest, power[k]);
  }
  const double least = highest * std::pow(10, options.min_level / 10);
  std::erase_if(peaks, [&](const Peak& peak) {
    return peak.power < least || peak.power < above_floor * floor_at(power, peak.bin, about);
  });
  std::sort(peaks.begin(), peaks.end(),
            [](const Peak& a, const Peak& b) { return a.power > b.power; });
  return peaks;
}

/// The mode of a peak, from the widest band in which it is all there is.
std::optional<ReverberantLine> line_at(std::span<const double> sound, double sample_rate,
                                       double frequency, double room_rate) {
  for (const double rate : band_rates) {
    const auto line = fit_line(band_signal(sound, sample_rate, frequency, rate), room_rate);
    if (!line || line->whiteness > max_whiteness) continue;
    const double width = (line->decay_rate + room_rate) / std::numbers::pi;
    const bool is_mode = line->level > min_line_level && line->decay_rate < rate &&
                         std::abs(line->frequency - frequency) < width &&
                         line->decay_rate_error < max_relative_error * line->decay_rate;
    if (is_mode) return line;
  }
  return {};
}

features::Feature feature_of(const ReverberantLine& line) {
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  features::Feature mode;
  mode.frequency = line.frequency;
  mode.decay_rate = line.decay_rate;
  mode.frequency_error = model_factor * line.frequency_error;
  mode.decay_rate_error =
      std::hypot(model_factor * line.decay_rate_error, model_error * line.decay_rate);
  mode.amplitude = mode.phase = mode.amplitude_error = unknown;
  mode.snr = core::decibels(line.level);
  return mode;
}

/// Whether a line is one of the modes, from another peak of it.
bool is_known(const ReverberantLine& line, std::span<const features::Feature> modes) {
  return std::any_of(modes.begin(), modes.end(), [&](const features::Feature& mode) {
    return std::abs(mode.frequency - line.frequency) < mode.decay_rate / std::numbers::pi;
  });
}

}  // namespace

ReverberantOptions reverberant_options(const features::FeatureOptions& options) {
  return {.onset = options.onset,
          .contact_time = options.contact_time,
          .min_frequency = options.min_frequency,
          .max_frequency = options.max_frequency,
          .min_level = options.min_level,
          .max_features = options.max_features};
}

std::vector<features::Feature> reverberant_modes(std::span<const double> samples,
                                                 double sample_rate, std::span<const double> rt60,
                                                 const ReverberantOptions& options) {
  if (!(sample_rate > 0))
    throw core::InputError(fmt::format("a sample rate of {} Hz", sample_rate));
  if (rt60.empty()) throw core::InputError("a room without a reverberation time");
  for (const double sample : samples) {
    if (!std::isfinite(sample)) throw core::InputError("a sample that is not finite");
  }
  const features::Segment segment =
      features::find_segment(samples, sample_rate, options.onset, options.contact_time);
  if (!segment.nothing.empty() || segment.begin >= segment.end) return {};
  std::vector<double> rates;
  for (const double time : rt60) {
    if (time > 0) rates.push_back(std::log(1000.0) / time);
  }
  if (rates.empty()) return {};
  const double typical = core::median(rates);
  const auto heard =
      std::min(segment.end - segment.begin,
               static_cast<std::size_t>(std::min(longest / typical * sample_rate, 1e15)));
  const auto sound = samples.subspan(segment.begin, heard);
  struct Taken {
    double frequency, width;
  };
  std::vector<Taken> taken;
  std::vector<features::Feature> modes;
  for (const Peak& peak : spectrum_peaks(sound, sample_rate, typical, options)) {
    if (modes.size() >= options.max_features || taken.size() >= max_tries) break;
    const auto covers = [&](const Taken& line) {
      return std::abs(line.frequency - peak.frequency) < line.width;
    };
    if (std::any_of(taken.begin(), taken.end(), covers)) continue;
    const double room_rate = features::room_decay_rate(rt60, peak.frequency);
    taken.push_back({peak.frequency, room_rate / std::numbers::pi});
    if (!std::isfinite(room_rate)) continue;
    const auto line = line_at(sound, sample_rate, peak.frequency, room_rate);
    if (!line || is_known(*line, modes)) continue;
    // The noise splits a line into peaks, which are the same mode.
    const double width = 1.5 * std::max(line->decay_rate, room_rate) / std::numbers::pi;
    taken.push_back({line->frequency, width});
    modes.push_back(feature_of(*line));
  }
  std::sort(modes.begin(), modes.end(),
            [](const auto& a, const auto& b) { return a.frequency < b.frequency; });
  return modes;
}

}  // namespace carillon::eval::damping
