#include "eval/features/segment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/numbers.hpp"

namespace carillon::eval::features {

namespace {

constexpr double frame_length = 0.001;    ///< [s]
constexpr double silent = 1e-7;           ///< of full scale, -140 dB
constexpr double onset_fraction = 0.01;   ///< of the loudest energy
constexpr double strike_rise = 4;         ///< 6 dB
constexpr double strike_fraction = 1e-3;  ///< -30 dB of the first
constexpr double min_steps = 100;         ///< of a converter, that a clipped value is large
constexpr std::size_t strike_gap = 20;    ///< frames after an onset that belong to it
constexpr std::size_t strike_before = 50;
constexpr std::size_t strike_within = 5;

/// Energy of the differences of neighbouring samples, frame by frame: what is struck anew shows in
/// high frequencies, which the ringing has lost.
std::vector<double> frame_energies(std::span<const double> samples, std::size_t frame) {
  std::vector<double> energies(samples.size() / frame);
  for (std::size_t k = 0; k < energies.size(); ++k) {
    double sum = 0;
    for (std::size_t n = std::max<std::size_t>(1, k * frame); n < (k + 1) * frame; ++n) {
      const double step = samples[n] - samples[n - 1];
      sum += step * step;
    }
    energies[k] = sum;
  }
  return energies;
}

/// Mean over three frames.
std::vector<double> smooth(const std::vector<double>& values) {
  std::vector<double> out(values.size());
  for (std::size_t k = 0; k < values.size(); ++k) {
    const std::size_t first = k > 0 ? k - 1 : 0, last = std::min(values.size() - 1, k + 1);
    double sum = 0;
    for (std::size_t i = first; i <= last; ++i) sum += values[i];
    out[k] = sum / static_cast<double>(last - first + 1);
  }
  return out;
}

std::size_t find_onset(std::span<const double> samples, const std::vector<double>& energy,
                       std::size_t frame) {
  const std::vector<double> level = smooth(energy);
  const auto loudest =
      static_cast<std::size_t>(std::max_element(level.begin(), level.end()) - level.begin());
  // What was there before, if the strike is not at the very beginning.
  double before = 0;
  if (loudest > 10) {
    before =
        core::median({level.begin(), level.begin() + static_cast<std::ptrdiff_t>(loudest / 2 + 1)});
    // A sound that already rings has no quiet before it.
    if (before > 0.1 * level[loudest]) before = 0;
  }
  const double threshold = std::max(onset_fraction * level[loudest], 6 * before);
  std::size_t first = loudest;
  while (first > 0 && level[first - 1] > threshold) --first;
  // To the sample: the first that is larger than all noise, or a hundredth of the largest.
  const std::size_t from = first > 1 ? (first - 2) * frame : 0;
  const std::size_t to = std::min(samples.size(), (loudest + 2) * frame);
  const double peak = core::peak(samples.subspan(from, to - from));
  const std::size_t quiet = from > 20 * frame ? from - 20 * frame : 0;
  const double noise = core::peak(samples.subspan(quiet, from - quiet));
  const double minimum = std::max(0.01 * peak, std::min(1.5 * noise, 0.5 * peak));
  for (std::size_t n = from; n < to; ++n) {
    if (std::abs(samples[n]) > minimum) return n;
  }
  return from;
}

/// First frame of the next strike, if there is one.
std::optional<std::size_t> next_strike(const std::vector<double>& energy, std::size_t onset) {
  double first = 0;
  for (std::size_t k = onset; k < std::min(energy.size(), onset + strike_gap); ++k) {
    first = std::max(first, energy[k]);
  }
  for (std::size_t k = onset + strike_gap; k + strike_within <= energy.size(); ++k) {
    double before = 0, after = 0;
    const std::size_t from = std::max(onset, k > strike_before ? k - strike_before : 0);
    for (std::size_t i = from; i < k; ++i) before = std::max(before, energy[i]);
    for (std::size_t i = k; i < k + strike_within; ++i) after = std::max(after, energy[i]);
    if (after > strike_rise * before && after > strike_fraction * first) return k;
  }
  return std::nullopt;
}

/// Runs of equal samples at the largest or smallest value that break off with a step.
struct Clipping {
  std::size_t count = 0;
  std::size_t last = 0;
};
Clipping find_clipping(std::span<const double> samples, std::size_t from, std::size_t to) {
  Clipping clipping;
  if (to - from < 8) return clipping;
  const auto [low, high] = std::minmax_element(samples.begin() + static_cast<std::ptrdiff_t>(from),
                                               samples.begin() + static_cast<std::ptrdiff_t>(to));
  // A converter's smallest step: tops of a few steps are flat without being cut.
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t n = from + 1; n < to; ++n) {
    const double difference = std::abs(samples[n] - samples[n - 1]);
    if (difference > 0) step = std::min(step, difference);
  }
  for (const double extreme : {*low, *high}) {
    if (std::abs(extreme) < min_steps * step) continue;
    for (std::size_t n = from; n < to;) {
      std::size_t last = n;
      while (last < to && samples[last] == extreme) ++last;
      const std::size_t run = last - n;
      if (run >= 3) {
        const double in = n > from ? std::abs(samples[n - 1] - extreme) : 0;
        const double out = last < to ? std::abs(samples[last] - extreme) : 0;
        if (std::max(in, out) > 0.01 * std::abs(extreme)) {
          clipping.count += run;
          clipping.last = std::max(clipping.last, last);
        }
      }
      n = last + 1;
    }
  }
  return clipping;
}

}  // namespace

Segment find_segment(std::span<const double> samples, double sample_rate,
                     std::optional<double> onset, double contact) {
  Segment segment;
  segment.end = samples.size();
  const auto frame = std::max<std::size_t>(1, static_cast<std::size_t>(frame_length * sample_rate));
  if (samples.size() < 16 * frame) {
    segment.nothing =
        fmt::format("too short: {} sample{}", samples.size(), samples.size() == 1 ? "" : "s");
    return segment;
  }
  const auto [low, high] = std::minmax_element(samples.begin(), samples.end());
  if (*high - *low < silent) {
    segment.nothing =
        std::max(std::abs(*low), std::abs(*high)) < silent ? "silent" : "constant: nothing moves";
    return segment;
  }
  const std::vector<double> energy = frame_energies(samples, frame);
  if (onset) {
    segment.onset = static_cast<std::size_t>(std::llround(*onset * sample_rate));
    if (segment.onset >= samples.size()) {
      segment.nothing = fmt::format("the onset given, {:g} s, is after its end", *onset);
      return segment;
    }
  } else {
    segment.onset = find_onset(samples, energy, frame);
  }
  if (const auto next = next_strike(energy, segment.onset / frame)) {
    segment.end = *next * frame;
    segment.remarks.push_back(
        fmt::format("another strike at {:.3f} s: what comes after it is left out",
                    static_cast<double>(segment.end) / sample_rate));
  }
  segment.begin = segment.onset + static_cast<std::size_t>(contact * sample_rate);
  const Clipping clipping = find_clipping(samples, segment.onset, segment.end);
  segment.clipped = clipping.count;
  if (clipping.last > segment.begin) {
    segment.begin = clipping.last + 1;
    segment.remarks.push_back(fmt::format(
        "{} samples are clipped: left out up to {:.1f} ms after the onset", clipping.count,
        1e3 * static_cast<double>(segment.begin - segment.onset) / sample_rate));
  } else if (clipping.count > 0) {
    segment.remarks.push_back(fmt::format("{} samples are clipped", clipping.count));
  }
  if (segment.begin + 16 * frame > segment.end) {
    segment.nothing =
        segment.clipped > 0
            ? "clipped to the end"
            : fmt::format(
                  "too short: {:.1f} ms after the strike",
                  1e3 * (static_cast<double>(segment.end) - static_cast<double>(segment.onset)) /
                      sample_rate);
  }
  return segment;
}

}  // namespace carillon::eval::features
