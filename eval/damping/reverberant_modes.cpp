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
constexpr double slow = 0.5;  ///< decay by the end of a mode that is slow if it is not told
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
                                 double room_rate, const features::FeatureOptions& options) {
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
  const double last = features::highest_mode(sample_rate, options);
  double highest = 0;
  for (std::size_t k = 1; k + 1 < power.size(); ++k) {
    const double frequency = static_cast<double>(k) * bin;
    if (frequency < options.min_frequency || frequency > last) continue;
    if (power[k] < power[k - 1] || power[k] <= power[k + 1]) continue;
    peaks.push_back({frequency, power[k], k});
    highest = std::max(highest, power[k]);
  }
  const double weakest = highest * std::pow(10, options.min_level / 10);
  std::erase_if(peaks, [&](const Peak& peak) {
    return peak.power < weakest || peak.power < above_floor * floor_at(power, peak.bin, about);
  });
  std::sort(peaks.begin(), peaks.end(),
            [](const Peak& a, const Peak& b) { return a.power > b.power; });
  return peaks;
}

/// The line of a peak, from the widest band in which it is all there is: a mode, or too slow to be
/// told.
std::optional<ReverberantLine> line_at(std::span<const double> sound, double sample_rate,
                                       double frequency, double room_rate) {
  for (const double rate : band_rates) {
    auto line = fit_line(band_signal(sound, sample_rate, frequency, rate), room_rate);
    if (!line || line->whiteness > max_whiteness) continue;
    const double width = (line->decay_rate + room_rate) / std::numbers::pi;
    const bool is_line = line->level > min_line_level && line->decay_rate < rate &&
                         std::abs(line->frequency - frequency) < width;
    const bool is_told = line->decay_rate_error < max_relative_error * line->decay_rate;
    const double seconds = static_cast<double>(sound.size()) / sample_rate;
    line->too_slow = line->too_slow || (!is_told && line->decay_rate * seconds < slow);
    if (is_line && (is_told || line->too_slow)) return line;
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

/// The rooms' decay rates of octaves that reverberate.
std::vector<double> decay_rates(std::span<const double> rt60) {
  std::vector<double> rates;
  for (const double time : rt60) {
    if (time > 0) rates.push_back(std::log(1000.0) / time);
  }
  return rates;
}

/// The lines of a sound's spectrum, each as what it is: a feature, a hum or too slow to be told.
/// @return how many are too slow
std::size_t sort_lines(std::span<const double> sound, double sample_rate, double typical_rate,
                       const features::FeatureOptions& options, features::FeatureSet& set) {
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  struct Taken {
    double frequency, width;
  };
  std::vector<Taken> taken;
  std::size_t too_slow = 0;
  for (const Peak& peak : spectrum_peaks(sound, sample_rate, typical_rate, options)) {
    if (set.features.size() >= options.max_features || taken.size() >= max_tries) break;
    const auto covers = [&](const Taken& line) {
      return std::abs(line.frequency - peak.frequency) < line.width;
    };
    if (std::any_of(taken.begin(), taken.end(), covers)) continue;
    const double room_rate = features::room_decay_rate(options.rt60, peak.frequency);
    taken.push_back({peak.frequency, room_rate / std::numbers::pi});
    if (!std::isfinite(room_rate)) continue;
    const auto line = line_at(sound, sample_rate, peak.frequency, room_rate);
    if (!line || is_known(*line, set.features)) continue;
    // The noise splits a line into peaks, which are the same mode.
    const double width = 1.5 * std::max(line->decay_rate, room_rate) / std::numbers::pi;
    taken.push_back({line->frequency, width});
    if (line->decay_rate < options.min_decay_rate.value_or(0)) {
      set.hums.push_back({line->frequency, line->decay_rate, unknown});
    } else if (line->too_slow) {
      ++too_slow;
    } else {
      set.features.push_back(feature_of(*line));
    }
  }
  return too_slow;
}

}  // namespace

features::FeatureSet reverberant_modes(std::span<const double> samples, double sample_rate,
                                       const features::FeatureOptions& options) {
  features::check_extraction(samples, sample_rate, options);
  if (!features::reverberates(options.rt60))
    throw core::InputError("a room without a reverberation time");
  const features::Segment segment =
      features::find_segment(samples, sample_rate, options.onset, options.contact_time);
  features::FeatureSet set = features::set_of_segment(segment, sample_rate);
  if (!set.nothing.empty()) return set;
  const double typical = core::median(decay_rates(options.rt60));
  const double seconds = std::min(options.duration, longest / typical);
  const auto looked_at = static_cast<std::size_t>(std::min(seconds * sample_rate, 1e15));
  const auto sound = samples.subspan(
      segment.begin, std::min(segment.end - std::min(segment.begin, segment.end), looked_at));
  set.end = set.begin + static_cast<double>(sound.size()) / sample_rate;
  const std::size_t too_slow =
      sound.empty() ? 0 : sort_lines(sound, sample_rate, typical, options, set);
  if (too_slow > 0) {
    set.remarks.push_back(fmt::format(
        "{} tone{} decay{} too slowly to be told in the {:.2g} s that are analysed", too_slow,
        too_slow == 1 ? "" : "s", too_slow == 1 ? "s" : "", set.end - set.begin));
  }
  const auto by_frequency = [](const auto& a, const auto& b) { return a.frequency < b.frequency; };
  std::sort(set.features.begin(), set.features.end(), by_frequency);
  std::sort(set.hums.begin(), set.hums.end(), by_frequency);
  if (set.features.empty()) {
    set.nothing =
        !set.hums.empty() || too_slow > 0
            ? "only steady tones"
            : "no line of the spectrum whose decay can be told from the noise and the room";
  }
  return set;
}

}  // namespace carillon::eval::damping
