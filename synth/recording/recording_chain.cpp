#include "synth/recording/recording_chain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/error.hpp"

namespace carillon::synth::recording {

namespace {

constexpr int tap_count = 128;
constexpr double beta = 10;

/// Taps h such that sum_j h[j] x[n + tap_count/2 - 1 - j] is x at n - fraction.
std::vector<double> fractional_taps(double fraction) {
  std::vector<double> taps(tap_count);
  double sum = 0;
  for (int j = 0; j < tap_count; ++j) {
    const double t = j - (tap_count / 2 - 1) - fraction;
    const double edge = t / (tap_count / 2);
    const double window = std::cyl_bessel_i(0, beta * std::sqrt(std::max(0.0, 1 - edge * edge)));
    const double sinc = t == 0 ? 1 : std::sin(std::numbers::pi * t) / (std::numbers::pi * t);
    taps[static_cast<std::size_t>(j)] = window * sinc;
    sum += window * sinc;
  }
  for (double& tap : taps) tap /= sum;
  return taps;
}

double step_of(int bits) {
  if (bits < 2 || bits > 24) {
    throw core::InputError(fmt::format("{} bits to a sample", bits), "2 to 24 are possible");
  }
  return std::ldexp(1.0, 1 - bits);
}

}  // namespace

void shift_later(std::span<float> clip, double delay) {
  if (!(delay >= 0) || !std::isfinite(delay)) {
    throw core::InputError(fmt::format("a shift by {} samples", delay),
                           "a clip can only be moved later, by a finite time");
  }
  const double whole = std::floor(delay);
  const double fraction = delay - whole;
  const std::size_t count = clip.size();
  const std::size_t moved =
      whole < static_cast<double>(count) ? static_cast<std::size_t>(whole) : count;
  if (fraction > 0 && moved < count) {
    const std::vector<double> taps = fractional_taps(fraction);
    const std::vector<float> before(clip.begin(), clip.end());
    const auto size = static_cast<std::ptrdiff_t>(count);
    for (std::ptrdiff_t n = 0; n < size; ++n) {
      double value = 0;
      for (std::ptrdiff_t j = 0; j < tap_count; ++j) {
        const std::ptrdiff_t at = n + tap_count / 2 - 1 - j;
        if (at >= 0 && at < size)
          value += taps[static_cast<std::size_t>(j)] * before[static_cast<std::size_t>(at)];
      }
      clip[static_cast<std::size_t>(n)] = static_cast<float>(value);
    }
  }
  if (moved == 0) return;
  std::copy_backward(clip.begin(), clip.end() - static_cast<std::ptrdiff_t>(moved), clip.end());
  std::fill(clip.begin(), clip.begin() + static_cast<std::ptrdiff_t>(moved), 0.0F);
}

void apply_gain(std::span<float> clip, double decibels) {
  const double factor = std::pow(10.0, decibels / 20);
  for (const float sample : clip) {
    if (!std::isfinite(static_cast<float>(factor * sample))) {
      throw core::InputError(
          fmt::format("a gain of {} dB goes beyond what single precision holds", decibels));
    }
  }
  for (float& sample : clip) sample = static_cast<float>(factor * sample);
}

std::size_t clip_at(std::span<float> clip, double level) {
  if (!(level > 0)) {
    throw core::InputError(fmt::format("clipping at {}", level), "the level must be positive");
  }
  const auto limit = static_cast<float>(level);
  std::size_t beyond = 0;
  for (float& sample : clip) {
    if (std::abs(sample) > limit) ++beyond;
    sample = std::clamp(sample, -limit, limit);
  }
  return beyond;
}

std::size_t quantise(std::span<float> clip, int bits, core::RandomStream* dither) {
  const double step = step_of(bits);
  const double top = 1 / step - 1;
  std::size_t beyond = 0;
  for (std::size_t i = 0; i < clip.size(); ++i) {
    if (!std::isfinite(clip[i])) {
      throw core::InputError(fmt::format("quantisation: sample {} is not finite", i));
    }
    double steps = clip[i] / step;
    if (dither != nullptr) {
      // Two uniform numbers of 32 bits from one of 64.
      const std::uint64_t bits64 = dither->next();
      steps +=
          (static_cast<double>(bits64 >> 32) - static_cast<double>(bits64 & 0xffffffffU)) * 0x1p-32;
    }
    const double rounded = std::nearbyint(steps);
    const double held = std::clamp(rounded, -top - 1, top);
    if (held != rounded) ++beyond;
    clip[i] = static_cast<float>(held * step);
  }
  return beyond;
}

void stop_at(std::span<float> clip, double end, double fade) {
  for (std::size_t i = 0; i < clip.size(); ++i) {
    const double left = end - static_cast<double>(i);
    if (left >= fade) continue;
    const double factor = left > 0 ? 0.5 - 0.5 * std::cos(std::numbers::pi * left / fade) : 0.0;
    clip[i] = static_cast<float>(factor * clip[i]);
  }
}

bool silent_after_rounding(std::span<const float> clip, int bits) {
  const double half = step_of(bits) / 2;
  return std::all_of(clip.begin(), clip.end(),
                     [&](float sample) { return std::abs(sample) <= half; });
}

}  // namespace carillon::synth::recording
