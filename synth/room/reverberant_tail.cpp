#include "synth/room/reverberant_tail.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "core/numbers.hpp"
#include "core/random.hpp"
#include "synth/room/detail/reverberation_time.hpp"
#include "synth/room/octave_filters.hpp"
#include "synth/signal/real_fft.hpp"

namespace carillon::synth::room {

namespace {

constexpr double energy_decay_60db = 6 * std::numbers::ln10;  ///< 60 dB of energy
constexpr double matched_time = 0.010;                        ///< [s] before the start
constexpr int enough_images = 6;
constexpr double tail_lengths = 1.5;       ///< of an octave's tail in reverberation times: 90 dB
constexpr double half_width = 1.0 / 24;    ///< of the crossings [octaves]
constexpr double lowest_frequency = 20;    ///< [Hz]; nothing below
constexpr std::size_t shortest = 4096;     ///< samples of noise: bins in every octave
constexpr double evened = 1.0;             ///< length of evening in 1 / bandwidth
constexpr int rounds = 3;                  ///< of evening
constexpr std::size_t few = 4;             ///< octaves whose decay is set right as a whole
constexpr double stretch_time = 0.1;       ///< between corrections, in reverberation times: 6 dB
constexpr std::size_t stretch_count = 10;  ///< 60 dB; what is later stays as the last one
constexpr int corrections = 4;             ///< rounds
constexpr double max_at_once = 1.0;        ///< of a correction [Np]

/// Mean over a box of 2 half + 1 samples of a periodic signal.
void smooth(std::vector<double>& values, std::size_t half) {
  const std::size_t n = values.size();
  const std::vector<double> before = values;
  double sum = 0;
  for (std::size_t i = 0; i <= 2 * half; ++i) sum += before[(n + i - half) % n];
  for (std::size_t i = 0; i < n; ++i) {
    values[i] = std::max(sum, 0.0) / static_cast<double>(2 * half + 1);
    sum += before[(i + half + 1) % n] - before[(i + n - half) % n];
  }
}

/// A band of noise whose power is evened out by itself.
struct NoiseBand {
  double low, high;  ///< [Hz]; no crossing at lowest_frequency and at half the sample rate
};

/// An octave, and for the lowest, which reaches down to 0 Hz, what lies below its own edge apart:
/// a filter of the octave must see an even decay.
std::vector<NoiseBand> noise_bands(std::size_t octave, std::size_t octaves, double sample_rate) {
  const double top = octave + 1 < octaves ? upper_edge(octave) : sample_rate / 2;
  std::vector<NoiseBand> bands = {{lower_edge(octave), top}};
  if (octave == 0) {
    bands.push_back({lower_edge(0) / 2, lower_edge(0)});
    bands.push_back({lowest_frequency, lower_edge(0) / 2});
  }
  std::erase_if(bands, [&](const NoiseBand& band) { return 2 * band.low >= sample_rate; });
  for (NoiseBand& band : bands) band.high = std::min(band.high, sample_rate / 2);
  return bands;
}

/// Adds noise of one band, with the power that white noise of unit power has in it, to the spectrum
/// of `count` samples.
void add_band_noise(const NoiseBand& band, double sample_rate, std::size_t count,
                    std::span<std::complex<double>> spectrum, core::RandomStream& random) {
  const double step = sample_rate / static_cast<double>(count);
  // Amplitudes of the bins in the band; the squares of all bands add up to 1 in every bin.
  const double reach = std::exp2(half_width);
  const double from = band.low == lowest_frequency ? lowest_frequency : band.low / reach;
  const double to = std::min(band.high * reach, sample_rate / 2);
  const auto first = std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(from / step)));
  std::vector<double> amplitudes;
  double energy = 0;
  for (std::size_t k = first; static_cast<double>(k) * step < to && 2 * k < count; ++k) {
    const double f = static_cast<double>(k) * step;
    const double fraction =
        (band.low == lowest_frequency ? 1 : crossing(f, band.low, half_width)) *
        (2 * band.high >= sample_rate ? 1 : 1 - crossing(f, band.high, half_width));
    amplitudes.push_back(std::sqrt(fraction));
    energy += fraction;
  }
  if (energy == 0) return;

  // The same bins of a shorter transform over the same time: low bands need few samples.
  signal::RealFft fft(std::min(count, signal::good_fft_size(static_cast<std::size_t>(
                                          2.5 * static_cast<double>(first + amplitudes.size())))));
  const auto bins = fft.spectrum();
  std::fill(bins.begin(), bins.end(), 0.0);
  for (std::size_t i = 0; i < amplitudes.size(); ++i) {
    const double re = random.normal();
    const double im = random.normal();
    bins[first + i] = amplitudes[i] * std::complex<double>(re, im);
  }
  // Evened noise reaches a little beyond its band, and cut back to it, it is a little less even: a
  // few rounds come to noise that is both.
  const double rate = step * static_cast<double>(fft.size());
  const auto half = std::min(static_cast<std::size_t>(evened * rate / (2 * (band.high - band.low))),
                             fft.size() / 4);
  const double scale = 1 / static_cast<double>(fft.size());
  const double power = 4 * energy * scale * scale;
  std::vector<double> local(fft.size());
  for (int round = 0; round < rounds; ++round) {
    fft.inverse();
    std::transform(fft.signal().begin(), fft.signal().end(), local.begin(),
                   [](double v) { return v * v; });
    smooth(local, half);
    smooth(local, half);
    for (std::size_t n = 0; n < fft.size(); ++n) {
      // Where the noise happens to be all but silent it is left so.
      fft.signal()[n] *= std::sqrt(power / std::max(local[n], 0.01 * power));
    }
    fft.forward();
    std::fill(bins.begin(), bins.begin() + static_cast<std::ptrdiff_t>(first), 0.0);
    std::fill(bins.begin() + static_cast<std::ptrdiff_t>(first + amplitudes.size()), bins.end(),
              0.0);
  }
  // What the cuts have taken is given back.
  double left = 0;
  for (std::size_t i = 0; i < amplitudes.size(); ++i) left += std::norm(bins[first + i]);
  const double gain = std::sqrt(energy * static_cast<double>(count) / left);
  for (std::size_t i = 0; i < amplitudes.size(); ++i) {
    spectrum[first + i] += gain * bins[first + i];
  }
}

/// Between the middles of stretches, straight in the logarithm.
double gain_at(std::span<const double> gains, double stretch) {
  const double x = std::clamp(stretch - 0.5, 0.0, static_cast<double>(gains.size() - 1));
  const auto i = std::min(static_cast<std::size_t>(x), gains.size() - 1);
  if (i + 1 == gains.size()) return gains[i];
  return gains[i] * std::pow(gains[i + 1] / gains[i], x - static_cast<double>(i));
}

/// Multiplies samples by the gains; sample n lies (n - first) / stretch stretches after the first
/// one's begin. One power for each piece between two middles.
void apply_gains(std::span<double> samples, std::span<const double> gains, double first,
                 double stretch) {
  for (std::size_t n = 0; n < samples.size();) {
    const double x = (static_cast<double>(n) - first) / stretch;
    const double piece = std::floor(x - 0.5);
    double factor = 1;
    double end = static_cast<double>(samples.size());
    if (piece < 0) {
      end = std::min(end, std::ceil(first + 0.5 * stretch));
    } else if (piece < static_cast<double>(gains.size() - 1)) {
      const auto i = static_cast<std::size_t>(piece);
      factor = std::pow(gains[i + 1] / gains[i], 1 / stretch);
      end = std::min(end, std::ceil(first + (piece + 1.5) * stretch));
    }
    const auto stop = std::max(n + 1, static_cast<std::size_t>(end));
    for (double gain = gain_at(gains, x); n < stop; ++n) {
      samples[n] *= gain;
      gain *= factor;
    }
  }
}

/// Slow corrections of an octave's noise, so that what an octave filter lets through falls by as
/// much as it should from one stretch of 6 dB to the next and has the prescribed time by T30. A low
/// octave is narrow: a stretch of its noise holds few independent values, and left to itself one
/// tail strays by a seventh.
/// @param first, last  samples between which the tail is alone
/// @param stretch      samples
/// @return  gains at the middles of stretches from `first` on
std::vector<double> stretch_gains(signal::RealFft& whole, std::size_t octave, double rt60,
                                  double sample_rate, double first, double last, double stretch) {
  const auto stretches =
      std::min(stretch_count, static_cast<std::size_t>(std::max(0.0, (last - first) / stretch)));
  if (stretches < 2) return {1.0};
  // The same time at a lower rate: bins up to twice the octave's end are enough.
  const double step = sample_rate / static_cast<double>(whole.size());
  signal::RealFft fft(std::min(whole.size(), signal::good_fft_size(static_cast<std::size_t>(
                                                 4 * upper_edge(octave) / step))));
  const double rate = step * static_cast<double>(fft.size());
  std::copy_n(whole.spectrum().begin(), fft.bins(), fft.spectrum().begin());
  fft.spectrum().back() = 0;
  fft.inverse();
  const double length = stretch * rate / sample_rate;
  const auto begin = static_cast<std::size_t>(first * rate / sample_rate);
  const auto end = std::min(fft.size(), static_cast<std::size_t>(last * rate / sample_rate));

  std::vector<double> gains(stretches, 1.0);
  std::vector<double> decay(end - begin);
  const double fall = std::exp(-energy_decay_60db / (2 * rt60 * rate));
  const auto heard = [&] {
    double envelope = 1;
    for (std::size_t n = 0; n < decay.size(); ++n) {
      decay[n] = fft.signal()[begin + n] * envelope;
      envelope *= fall;
    }
    apply_gains(decay, gains, 0, length);
    return octave_band(decay, rate, octave_centres[octave]);
  };
  for (int round = 0; round < corrections; ++round) {
    const std::vector<double> band = heard();
    std::vector<double> levels(stretches, 0.0);
    for (std::size_t n = 0; n < band.size(); ++n) {
      const auto s = static_cast<std::size_t>(static_cast<double>(n) / length);
      if (s < stretches) levels[s] += band[n] * band[n];
    }
    // Over the ideal decay; their mean is the tail's level and stays.
    double mean = 0;
    for (std::size_t s = 0; s < stretches; ++s) {
      levels[s] = std::log(std::max(levels[s], 1e-300)) +
                  energy_decay_60db * stretch_time * static_cast<double>(s);
      mean += levels[s] / static_cast<double>(stretches);
    }
    for (std::size_t s = 0; s < stretches; ++s) {
      gains[s] *= std::exp(std::clamp((mean - levels[s]) / 2, -max_at_once, max_at_once));
    }
  }
  for (int round = 0; round < corrections; ++round) {
    const auto found = reverberation_time(heard(), rate);
    if (!found) break;  // a clip that ends before 45 dB are gone
    const double slope = energy_decay_60db / 2 * stretch_time * (rt60 / found->rt60 - 1);
    for (std::size_t s = 0; s < stretches; ++s) {
      gains[s] *= std::exp(std::clamp(slope, -0.1, 0.1) *
                           (static_cast<double>(s) - static_cast<double>(stretches - 1) / 2));
    }
  }
  return gains;
}

}  // namespace

double TailPlan::energy_db() const {
  double loudest = 0;
  for (std::size_t b = 0; b < octave_count; ++b) {
    loudest = std::max(loudest, power[b] * rt60[b] / energy_decay_60db);
  }
  return core::decibels(std::max(loudest, 1e-300));
}

TailPlan plan_tail(const Eigen::Vector3d& size, std::span<const ImageSource> images, double beyond,
                   double direct, const WallAbsorption& walls, const Air& air,
                   std::size_t octaves) {
  const double speed = sound_speed(air);
  const OctaveValues m = air_absorption(air);
  TailPlan plan;
  plan.direct = direct;
  plan.start = std::max(0.0, (beyond - direct) / speed);
  plan.rt60 = eyring(size, mean_absorption(size, walls), air);
  for (std::size_t b = octaves; b < octave_count; ++b) plan.rt60[b] = 0;
  plan.level.fill(1);

  const auto rate = [&](std::size_t b) { return energy_decay_60db / plan.rt60[b]; };
  // The direct sound is 1 whatever air has taken from it: so much more is everything else.
  for (std::size_t b = 0; b < octaves; ++b) {
    if (plan.rt60[b] == 0) continue;
    plan.power[b] = 4 * std::numbers::pi * speed * direct * direct / size.prod() *
                    std::exp(m[b] * direct - rate(b) * (direct / speed + plan.start));
  }

  // Energy of the images before the start, and in each step after it.
  const double matched = std::min(matched_time, plan.start);
  OctaveValues before{};
  int count = 0;
  std::vector<OctaveValues> after;
  for (const ImageSource& image : images) {
    const double time = (image.distance - direct) / speed - plan.start;
    if (time < -matched) continue;
    const OctaveValues gains = image_gains(image, direct, walls, m);
    if (time < 0) ++count;
    const auto step = static_cast<std::size_t>(std::max(time, 0.0) / plan.step);
    if (time >= 0 && after.size() <= step) after.resize(step + 1, OctaveValues{});
    OctaveValues& sum = time < 0 ? before : after[step];
    for (std::size_t b = 0; b < octaves; ++b) sum[b] += gains[b] * gains[b];
  }

  plan.fill.assign(after.size(), OctaveValues{});
  for (std::size_t b = 0; b < octaves; ++b) {
    if (plan.power[b] == 0) continue;
    if (count >= enough_images) {
      const double expected = plan.power[b] * std::expm1(rate(b) * matched) / rate(b);
      const double found = before[b] / expected;
      plan.level[b] = std::clamp(found, 0.25, 4.0);
      // An octave of which walls or air leave nothing has no step that is heard.
      const double step = core::decibels(std::max(found, 1e-12) / plan.level[b]);
      if (std::abs(step) > std::abs(plan.join_db)) plan.join_db = step;
      plan.power[b] *= plan.level[b];
    }
    double owed = 0;  // images that had more than their step leave less to the next ones
    for (std::size_t s = 0; s < after.size(); ++s) {
      const double whole = plan.power[b] * std::exp(-rate(b) * plan.step * static_cast<double>(s)) *
                           -std::expm1(-rate(b) * plan.step) / rate(b);
      const double left = whole - after[s][b] - owed;
      owed = std::max(0.0, -left);
      plan.fill[s][b] = whole > 0 ? std::clamp(left / whole, 0.0, 1.0) : 0.0;
    }
  }
  return plan;
}

std::vector<double> reverberant_tail(const TailPlan& plan, double sample_rate, std::size_t count,
                                     std::uint64_t seed, std::uint64_t room) {
  const std::size_t octaves = octaves_below_nyquist(sample_rate);
  const double first_sample = std::ceil(plan.start * sample_rate);
  if (!(first_sample < static_cast<double>(count))) return {};
  const auto start = static_cast<std::size_t>(first_sample);
  const auto length = [&](std::size_t b) {
    return static_cast<std::size_t>(std::min(std::ceil(tail_lengths * plan.rt60[b] * sample_rate),
                                             static_cast<double>(count - start)));
  };
  std::size_t longest = 0;
  for (std::size_t b = 0; b < octaves; ++b) {
    if (plan.power[b] > 0) longest = std::max(longest, length(b));
  }
  if (longest == 0) return {};
  std::vector<double> tail(start + longest, 0.0);
  signal::RealFft fft(signal::good_fft_size(std::max(longest, shortest)));
  for (std::size_t b = 0; b < octaves; ++b) {
    if (plan.power[b] == 0) continue;
    std::fill(fft.spectrum().begin(), fft.spectrum().end(), 0.0);
    core::RandomStream random(seed, room, fmt::format("room.tail.{}", b));
    for (const NoiseBand& band : noise_bands(b, octaves, sample_rate)) {
      add_band_noise(band, sample_rate, fft.size(), fft.spectrum(), random);
    }
    const std::size_t end = length(b);
    const double stretch = stretch_time * plan.rt60[b] * sample_rate;
    const double first = plan.step * static_cast<double>(plan.fill.size()) * sample_rate;
    std::vector<double> gains = {1.0};
    if (b < few) {
      gains = stretch_gains(fft, b, plan.rt60[b], sample_rate, first, static_cast<double>(end),
                            stretch);
    }
    fft.inverse();
    if (gains.size() > 1) {
      apply_gains(fft.signal().first(end), gains, first, stretch);
    }
    const double decay = std::exp(-energy_decay_60db / (2 * plan.rt60[b] * sample_rate));
    double envelope = std::sqrt(plan.power[b] / sample_rate);
    for (std::size_t n = 0; n < end; ++n) {
      const auto step = static_cast<std::size_t>(static_cast<double>(n) / sample_rate / plan.step);
      const double fill = step < plan.fill.size() ? std::sqrt(plan.fill[step][b]) : 1.0;
      tail[start + n] += fill * envelope * fft.signal()[n];
      envelope *= decay;
    }
  }
  return tail;
}

}  // namespace carillon::synth::room
