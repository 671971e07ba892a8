#include "eval/material/room_sound.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/numbers.hpp"

namespace carillon::eval::material {

namespace {

constexpr std::size_t few_companions = 20;
constexpr std::size_t companions_per_mode = 3;
constexpr std::size_t nearest_companions = 15;
/// Standard deviation of the logarithms of a room's decay rates, at most: 0.5 to 0.95 were measured
/// in rooms. What an object leaves beside its own modes (beats, glides, bursts) decays as they do,
/// at rates from one end of the band to the other: 1.2 to 1.6 of a ceramic bowl without a room.
constexpr double widest_rates = 1.1;
/// Median decay rate of companions over the room's ln(1000) / RT60.
constexpr double companion_rate = 1.6;
constexpr double same_line = 20 * std::numbers::ln2 / 1200;
constexpr double weaker_in_line = 10;  // [dB]
constexpr double exact = 0.06;         // standard error of a decay rate that can be relied on

double deviation_of(std::span<const double> values) {
  const auto count = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / count;
  double squares = 0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / count);
}

/// Of a decay rate; infinite where it is not known.
double relative_error(const features::Feature& feature) {
  const double error = feature.decay_rate_error / feature.decay_rate;
  return std::isfinite(error) ? error : core::infinity;
}

}  // namespace

RoomSound::RoomSound(std::span<const double> rt60) {
  if (features::reverberates(rt60)) rt60_.assign(rt60.begin(), rt60.end());
}

RoomSound::RoomSound(const features::FeatureSet& set, std::span<const std::size_t> heads) {
  for (std::size_t i = 0; i < set.features.size(); ++i) {
    if (std::find(heads.begin(), heads.end(), i) != heads.end()) continue;
    log_frequencies_.push_back(std::log(set.features[i].frequency));
    log_rates_.push_back(std::log(set.features[i].decay_rate));
  }
  const bool many =
      log_rates_.size() >= std::max(few_companions, companions_per_mode * heads.size());
  if (many && deviation_of(log_rates_) < widest_rates) return;
  log_frequencies_.clear();
  log_rates_.clear();
}

double RoomSound::rate_at(double frequency) const {
  if (!rt60_.empty()) return companion_rate * features::room_decay_rate(rt60_, frequency);
  if (log_rates_.empty()) return core::infinity;
  std::vector<std::size_t> order(log_rates_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto distance = [&](std::size_t i) {
    return std::abs(log_frequencies_[i] - std::log(frequency));
  };
  const std::size_t count = std::min(nearest_companions, order.size());
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(),
                    [&](std::size_t a, std::size_t b) { return distance(a) < distance(b); });
  std::vector<double> near;
  for (std::size_t i = 0; i < count; ++i) near.push_back(log_rates_[order[i]]);
  return std::exp(core::median(near));
}

std::optional<double> RoomSound::rt60() const {
  if (!rt60_.empty()) return *std::max_element(rt60_.begin(), rt60_.end());
  if (log_rates_.empty()) return std::nullopt;
  return companion_rate * std::log(1000) / std::exp(core::median(log_rates_));
}

const features::Feature& slowest_in_line(const features::FeatureSet& set, std::size_t head,
                                         std::span<const std::size_t> heads) {
  const auto distance = [&](std::size_t of, const features::Feature& feature) {
    return std::abs(std::log(feature.frequency / set.features[of].frequency));
  };
  const auto is_anothers = [&](const features::Feature& feature) {
    return std::any_of(heads.begin(), heads.end(), [&](std::size_t other) {
      return other != head &&
             (distance(other, feature) < distance(head, feature) ||
              (other < head && distance(other, feature) == distance(head, feature)));
    });
  };
  const features::Feature& strongest = set.features[head];
  const features::Feature* slowest = &strongest;
  bool found = false;
  for (const features::Feature& feature : set.features) {
    if (distance(head, feature) > same_line || is_anothers(feature)) continue;
    if (!(feature.snr > strongest.snr - weaker_in_line)) continue;
    if (!(feature.decay_rate_error < exact * feature.decay_rate)) continue;
    if (found && feature.decay_rate >= slowest->decay_rate) continue;
    slowest = &feature;
    found = true;
  }
  return *slowest;
}

DampingPoints damping_points(std::span<const features::FeatureSet> recordings,
                             std::span<const std::vector<FeatureIndex>> modes,
                             std::span<const double> rt60) {
  std::vector<std::vector<std::size_t>> heads(recordings.size());
  for (const std::vector<FeatureIndex>& mode : modes) {
    for (const FeatureIndex& head : mode) heads[head.recording].push_back(head.feature);
  }
  DampingPoints points;
  std::vector<RoomSound> rooms;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    rooms.push_back(rt60.empty() ? RoomSound(recordings[r], heads[r]) : RoomSound(rt60));
    if (const auto time = rooms.back().rt60()) {
      points.rt60 = std::max(points.rt60.value_or(0), *time);
    }
  }
  std::vector<features::Feature> chosen;
  for (const std::vector<FeatureIndex>& mode : modes) {
    std::optional<features::Feature> best;
    double room = core::infinity;
    for (const FeatureIndex& head : mode) {
      const features::FeatureSet& set = recordings[head.recording];
      const RoomSound& around = rooms[head.recording];
      features::Feature feature = around.heard()
                                      ? slowest_in_line(set, head.feature, heads[head.recording])
                                      : set.features[head.feature];
      if (around.heard()) feature.reverberant = false;  // the fit tells
      if (feature.reverberant) continue;
      if (best && !(relative_error(feature) < relative_error(*best))) continue;
      best = feature;
      room = 2 * around.rate_at(feature.frequency);
    }
    if (!best) continue;
    chosen.push_back(*best);
    points.rooms.push_back(room);
  }
  points.data = damping::damping_data(chosen);
  return points;
}

}  // namespace carillon::eval::material
