#include "eval/features/detail/reverberation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace carillon::eval::features {

namespace {

/// ln of power ratios: by what a mode stands out of the room, and above the noise when it does.
const double above_room = 2.5 * std::numbers::ln10, above_noise = std::numbers::ln10;

/// ln of a feature's power at a time after the onset.
double log_power(const Feature& feature, double time) {
  return 2 * (std::log(feature.amplitude) - feature.decay_rate * time);
}

bool stands_out(const Feature& feature, std::span<const Feature> all, const Late& late,
                double room_rate) {
  if (feature.decay_rate >= room_rate) return false;
  const double width = room_rate / std::numbers::pi;
  double around = 0;  // power at the begin against the feature's own
  for (const Feature& other : all) {
    if (std::abs(other.frequency - feature.frequency) > width) continue;
    if (!std::isfinite(other.amplitude)) continue;  // gone at once, and beyond numbers at the onset
    around += std::exp(log_power(other, late.begin) - log_power(feature, late.begin));
  }
  // Time until it is that near to the noise, or the end.
  const double heard = std::min(late.length, (feature.snr / 10 * std::numbers::ln10 - above_noise) /
                                                 (2 * feature.decay_rate));
  return 2 * (room_rate - feature.decay_rate) * heard - std::log(around) > above_room;
}

}  // namespace

void mark_faster(std::span<const double> rt60, std::vector<Feature>& features) {
  for (Feature& feature : features) {
    feature.reverberant = feature.decay_rate > room_decay_rate(rt60, feature.frequency);
  }
}

double time_to_stand_out(double room_rate) {
  return above_room / (2 * room_rate);
}

std::vector<Feature> outlasting(std::span<const Feature> features, const Late& late,
                                std::span<const double> rt60) {
  std::vector<Feature> modes;
  for (const Feature& feature : features) {
    const double room_rate = room_decay_rate(rt60, feature.frequency);
    if (!std::isfinite(room_rate) || !stands_out(feature, features, late, room_rate)) continue;
    modes.push_back(feature);
  }
  return modes;
}

std::vector<Feature> replaced_by(std::span<const Feature> modes, std::vector<Feature> early,
                                 std::span<const double> rt60) {
  for (Feature& feature : early) {
    feature.reverberant = std::isfinite(room_decay_rate(rt60, feature.frequency));
  }
  for (const Feature& mode : modes) {
    const double line = mode.decay_rate / (2 * std::numbers::pi);
    std::erase_if(early, [&](const Feature& other) {
      return other.reverberant && std::abs(other.frequency - mode.frequency) < line;
    });
  }
  early.insert(early.end(), modes.begin(), modes.end());
  return early;
}

}  // namespace carillon::eval::features
