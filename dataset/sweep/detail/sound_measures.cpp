#include "dataset/sweep/detail/sound_measures.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include "core/numbers.hpp"
#include "synth/signal/real_fft.hpp"

namespace carillon::dataset::sweep {

namespace {

constexpr double frame_s = 0.005;
constexpr double fall_db = 30;
constexpr std::size_t fewest_frames = 4;

std::vector<double> frame_levels(std::span<const float> clip, std::size_t frame) {
  std::vector<double> levels;
  for (std::size_t from = 0; from + frame <= clip.size(); from += frame) {
    double power = 0;
    for (const float x : clip.subspan(from, frame)) power += static_cast<double>(x) * x;
    levels.push_back(core::decibels(power / static_cast<double>(frame)));
  }
  return levels;
}

/// Slope of a straight line through values at 0, 1, 2, ...
double slope(std::span<const double> values) {
  const double n = static_cast<double>(values.size());
  const double middle = (n - 1) / 2;
  double above = 0, below = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double x = static_cast<double>(i) - middle;
    above += x * values[i];
    below += x * x;
  }
  return above / below;
}

std::optional<double> decay_time(std::span<const float> clip, double sample_rate) {
  const auto frame = static_cast<std::size_t>(std::lround(frame_s * sample_rate));
  if (frame == 0) return {};
  const std::vector<double> levels = frame_levels(clip, frame);
  if (levels.empty()) return {};
  const auto loudest = std::max_element(levels.begin(), levels.end());
  const auto end =
      std::find_if(loudest, levels.end(), [&](double level) { return level < *loudest - fall_db; });
  const std::span<const double> falling(loudest, end);
  if (falling.size() < fewest_frames) return {};
  const double per_second = slope(falling) * sample_rate / static_cast<double>(frame);
  if (!(per_second < 0)) return {};
  return -60 / per_second;
}

double centroid(std::span<const float> clip, double sample_rate) {
  synth::signal::RealFft fft(synth::signal::good_fft_size(clip.size()));
  std::fill(fft.signal().begin(), fft.signal().end(), 0.0);
  std::copy(clip.begin(), clip.end(), fft.signal().begin());
  fft.forward();
  double moment = 0, power = 0;
  for (std::size_t k = 0; k < fft.bins(); ++k) {
    const double one = std::norm(fft.spectrum()[k]);
    moment += static_cast<double>(k) * one;
    power += one;
  }
  return moment / power * sample_rate / static_cast<double>(fft.size());
}

}  // namespace

std::optional<SoundMeasures> measure_sound(std::span<const float> clip, double sample_rate) {
  const double peak = core::peak(clip);
  if (!(peak > 0)) return {};
  double power = 0;
  for (const float x : clip) power += static_cast<double>(x) * x;
  SoundMeasures measures;
  measures.level_db = core::decibels(power / static_cast<double>(clip.size()));
  measures.peak_db = core::amplitude_decibels(peak);
  measures.centroid_hz = centroid(clip, sample_rate);
  measures.decay_s = decay_time(clip, sample_rate);
  return measures;
}

}  // namespace carillon::dataset::sweep
