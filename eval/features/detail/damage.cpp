#include "eval/features/detail/damage.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/numbers.hpp"

namespace carillon::eval::features {

namespace {

constexpr double min_steps = 100;       ///< of a converter, that a clipped value is large
constexpr double missing_time = 0.001;  ///< [s]
constexpr double before_gap = 0.005;  ///< in which a sound is there before samples are missing [s]
constexpr double steps_of_a_sound = 16;    ///< of a converter: the last few are flat as well
constexpr double share_of_a_sound = 1e-3;  ///< of its peak

/// Smallest difference of two samples: one step of the converter, or less.
double smallest_step(std::span<const double> samples) {
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t n = 1; n < samples.size(); ++n) {
    const double difference = std::abs(samples[n] - samples[n - 1]);
    if (difference > 0) step = std::min(step, difference);
  }
  return step;
}

}  // namespace

Clipping find_clipping(std::span<const double> samples, std::size_t from, std::size_t to) {
  Clipping clipping;
  if (to < from + 8) return clipping;
  const auto [low, high] = std::minmax_element(samples.begin() + static_cast<std::ptrdiff_t>(from),
                                               samples.begin() + static_cast<std::ptrdiff_t>(to));
  // Tops of a few steps are flat without being cut.
  const double step = smallest_step(samples.subspan(from, to - from));
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

std::optional<std::size_t> limited_until(std::span<const double> samples, std::size_t from,
                                         std::size_t to) {
  constexpr double high = 0.93, middle = 0.79, low = 0.75;  // of the largest
  constexpr double ratio = 1.2, contrast = 0.25;
  constexpr std::size_t enough = 12;
  if (to < from + 8) return std::nullopt;
  const double peak = core::peak(samples.subspan(from, to - from));
  std::size_t above = 0, below = 0, falls = 0, last = from;
  bool after_high = false;
  for (std::size_t n = from + 1; n + 1 < to; ++n) {
    const double size = std::abs(samples[n]);
    if (size < std::abs(samples[n - 1]) || size <= std::abs(samples[n + 1])) continue;
    const bool is_high = size >= high * peak;
    if (is_high) {
      ++above;
      last = n;
    } else if (size >= middle * peak) {
      ++below;
    }
    if (after_high && size < low * peak) ++falls;
    after_high = is_high;
  }
  const auto highest = static_cast<double>(above);
  const bool falls_later = 2 * (last - from) < to - from;
  const bool limited = falls_later && above >= enough &&
                       highest > ratio * static_cast<double>(below) &&
                       static_cast<double>(falls) > contrast * highest;
  return limited ? std::optional(last + 1) : std::nullopt;
}

std::optional<Gap> find_gap(std::span<const double> samples, std::size_t from, double sample_rate) {
  const auto enough =
      std::max<std::size_t>(16, static_cast<std::size_t>(missing_time * sample_rate));
  while (from + 1 < samples.size() && samples[from + 1] == samples[from]) ++from;
  const std::span<const double> sound = samples.subspan(std::min(from, samples.size()));
  const double peak = core::peak(sound), step = smallest_step(sound);
  for (std::size_t n = 1; n < sound.size();) {
    std::size_t last = n + 1;
    while (last < sound.size() && sound[last] == sound[n]) ++last;
    if (last - n >= enough && std::abs(sound[n]) < 0.5 * peak) {
      const auto window = std::min(n, static_cast<std::size_t>(before_gap * sample_rate));
      const double there = core::peak(sound.subspan(n - window, window));
      return Gap{from + n, there > share_of_a_sound * peak && there > steps_of_a_sound * step};
    }
    n = last;
  }
  return std::nullopt;
}

}  // namespace carillon::eval::features
