#include "eval/material/match_ratio.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/numbers.hpp"
#include "synth/modal/hearing.hpp"

namespace carillon::eval::material {

namespace {

/// Exponent of intensity in loudness (Zwicker and Fastl 2007, section 8.7).
constexpr double prominence_exponent = 0.23;
/// Decay rates below ring for longer than any clip [1/s].
constexpr double slowest = 1e-3;

double square(double x) {
  return x * x;
}

}  // namespace

double audible_energy(const features::Feature& feature) {
  const double threshold = std::min(300.0, synth::modal::hearing_threshold(feature.frequency));
  return core::amplitude_decibels(std::max(feature.amplitude, 1e-300)) -
         core::decibels(4 * std::max(feature.decay_rate, slowest)) - threshold;
}

std::vector<FeaturePlace> places_of(std::span<const features::Feature> features,
                                    const MatchScale& scale) {
  std::vector<FeaturePlace> places;
  places.reserve(features.size());
  double loudest = -std::numeric_limits<double>::infinity();
  for (const features::Feature& feature : features) {
    FeaturePlace place;
    place.bark = synth::modal::bark(feature.frequency);
    place.duration = std::log(1 / std::max(feature.decay_rate, slowest) + scale.shortest_duration);
    place.level = core::amplitude_decibels(std::max(feature.amplitude, 1e-300));
    place.reverberant = feature.reverberant;
    place.prominence = audible_energy(feature);
    loudest = std::max(loudest, place.prominence);
    places.push_back(place);
  }
  const double minimum = std::pow(10, -prominence_exponent * scale.range / 10);
  for (FeaturePlace& place : places) {
    const double weight = std::pow(10, prominence_exponent * (place.prominence - loudest) / 10);
    place.prominence = std::max(0.0, weight - minimum);
  }
  return places;
}

double similarity(const FeaturePlace& a, const FeaturePlace& b, const MatchScale& scale) {
  const double longer =
      a.reverberant || b.reverberant ? 0 : (a.duration - b.duration) / scale.duration;
  return 1 / ((1 + square((a.bark - b.bark) / scale.bark)) * (1 + square(longer)) *
              (1 + square((a.level - b.level) / scale.level)));
}

BestMatch best_match(const FeaturePlace& feature, std::span<const FeaturePlace> set,
                     const MatchScale& scale) {
  BestMatch best;
  for (std::size_t j = 0; j < set.size(); ++j) {
    const double k = similarity(feature, set[j], scale);
    if (k > best.similarity) best = {j, k};
  }
  return best;
}

double match_ratio(std::span<const FeaturePlace> from, std::span<const FeaturePlace> to,
                   const MatchScale& scale) {
  double sum = 0;
  double weights = 0;
  for (const FeaturePlace& feature : from) {
    if (feature.prominence == 0) continue;
    sum += feature.prominence * best_match(feature, to, scale).similarity;
    weights += feature.prominence;
  }
  return weights > 0 ? sum / weights : 0;
}

}  // namespace carillon::eval::material
