#include "eval/material/detail/judge_estimate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/numbers.hpp"

namespace carillon::eval::material {

namespace {

/// The metric's rise that bounds the ranges.
constexpr double rise = 1.1;
/// Above all that hybrid_metric() gives.
constexpr double worst = 1e9;
/// Minima within this factor of the best compete with it.
constexpr double rival = 1.5;

void match(MaterialEstimate& estimate, std::span<const features::Feature> features,
           const Objective& objective) {
  const HeardCandidate heard =
      heard_candidate(objective.modes, estimate.candidate, objective.motion,
                      objective.reference.low, objective.reference.high);
  estimate.tones = heard.tones;
  const MatchScale& scale = objective.reference.options.match;
  const auto places = places_of(heard.tones, scale);
  double weights = 0;
  double squares = 0;
  double mean = 0;
  double weights_squared = 0;
  std::vector<std::pair<double, double>> distances;  // weight, cents
  for (std::size_t i = 0; i < features.size(); ++i) {
    const FeaturePlace& place = objective.reference.places[i];
    const BestMatch best = best_match(place, places, scale);
    if (best.similarity == 0) continue;
    // Levels and durations may be far off; a mode is told by its pitch.
    const bool near = std::abs(place.bark - places[best.index].bark) <= scale.bark;
    const MatchedFeature matched{i, heard.modes[best.index], heard.tones[best.index],
                                 best.similarity, near};
    estimate.matches.push_back(matched);
    if (!near) continue;
    const double distance = core::cents(features[i].frequency / matched.tone.frequency);
    distances.emplace_back(place.prominence, distance);
    weights += place.prominence;
    weights_squared += place.prominence * place.prominence;
    mean += place.prominence * distance;
    squares += place.prominence * distance * distance;
  }
  estimate.modulus_error = std::numeric_limits<double>::infinity();
  if (!(weights > 0)) return;
  mean /= weights;
  estimate.rms_cents = std::sqrt(squares / weights);
  const double effective = weights * weights / weights_squared;
  if (effective <= 1) return;
  const double variance =
      std::max(0.0, squares / weights - mean * mean) * effective / (effective - 1);
  // A modulus goes with the square of frequency.
  estimate.modulus_error = 2 * std::log(2.0) / 1200 * std::sqrt(variance / effective);
}

/// How far one coordinate goes before the metric has risen.
double reach(const Objective& objective, const std::vector<double>& x, std::size_t k, double step,
             double limit) {
  const auto risen = [&](double distance) {
    std::vector<double> moved = x;
    moved[k] += distance;
    return objective.metric(moved) > limit;
  };
  double inside = 0;
  double outside = step;
  while (!risen(outside)) {
    inside = outside;
    outside *= 2;
    if (std::abs(outside) > 20) return std::copysign(std::numeric_limits<double>::infinity(), step);
  }
  for (int i = 0; i < 10; ++i) {
    const double middle = 0.5 * (inside + outside);
    (risen(middle) ? outside : inside) = middle;
  }
  return inside;
}

void find_ranges(MaterialEstimate& estimate, const Objective& objective) {
  const Coordinates& coordinates = objective.coordinates;
  const std::vector<double> x = to_coordinates(coordinates, estimate.candidate);
  const std::vector<double> steps = first_steps(coordinates);
  const double limit = rise * objective.metric(x);
  const std::size_t first = first_damping(coordinates);
  for (std::size_t k = first; k < x.size(); ++k) {
    core::Range interval;
    for (const double side : {-1.0, 1.0}) {
      const double distance = reach(objective, x, k, 0.1 * side * steps[k], limit);
      double end = distance;  // beyond all limits
      if (std::isfinite(distance)) {
        std::vector<double> moved = x;
        moved[k] += distance;
        end = from_coordinates(coordinates, moved).damping.parameters[k - first];
      } else if (side < 0 && is_logarithm(coordinates, k)) {
        end = 0;
      }
      (side < 0 ? interval.low : interval.high) = end;
    }
    estimate.ranges.push_back(interval);
  }
}

void remark(MaterialEstimate& estimate, std::span<const features::Feature> features,
            const Objective& objective) {
  auto& remarks = estimate.remarks;
  const auto matched = std::count_if(estimate.matches.begin(), estimate.matches.end(),
                                     [](const MatchedFeature& feature) { return feature.near; });
  const auto total = static_cast<std::ptrdiff_t>(features.size());
  if (2 * matched < total) {
    remarks.push_back(fmt::format(
        "poorly determined: {} of {} features lie near a mode of the estimate; is it this object, "
        "struck there, and is its mesh true to size?",
        matched, total));
  }
  if (estimate.minima.size() > 1) {
    const LocalMinimum& second = estimate.minima[1];
    const double apart =
        std::abs(std::log(second.candidate.specific_modulus / estimate.candidate.specific_modulus));
    // Minima within the error are one finding.
    if (second.value.metric < rival * estimate.value.metric &&
        !(apart < 3 * estimate.modulus_error)) {
      remarks.push_back(fmt::format(
          "ambiguous: a specific modulus of {:.4g} m^2/s^2 fits nearly as well (metric {:.3g} "
          "against {:.3g})",
          second.candidate.specific_modulus, second.value.metric, estimate.value.metric));
    }
  }
  const double known =
      objective.modes.complete_to_hz *
      std::sqrt(estimate.candidate.specific_modulus / objective.modes.specific_modulus);
  const auto above =
      std::count_if(features.begin(), features.end(),
                    [&](const features::Feature& feature) { return feature.frequency > known; });
  if (above > 0) {
    remarks.push_back(
        fmt::format("modes of this material are known up to {:.0f} Hz and {} feature{} above: "
                    "assume a material nearer to it, or raise --max-frequency",
                    known, above, above == 1 ? " lies" : "s lie"));
  }
  for (std::size_t k = 0; k < estimate.ranges.size(); ++k) {
    const core::Range& range = estimate.ranges[k];
    if (!std::isfinite(range.high) || !std::isfinite(range.low)) {
      remarks.push_back(
          fmt::format("{} is not bounded by this recording", synth::damping::parameter_name(k)));
    }
  }
  if (!estimate.converged) remarks.emplace_back("the search ended before it had converged");
  remarks.emplace_back(
      "the specific modulus takes in the object's size: an object 1 % larger than its mesh comes "
      "out "
      "2 % lower");
}

}  // namespace

MetricValue Objective::value_of(const Candidate& candidate) const {
  return hybrid_metric(reference,
                       heard_candidate(modes, candidate, motion, reference.low, reference.high));
}

double Objective::metric(std::span<const double> x) const {
  for (const double value : x) {
    if (!std::isfinite(value)) return worst;
  }
  const Candidate candidate = from_coordinates(coordinates, x);
  if (!(candidate.specific_modulus >= limits.min_modulus &&
        candidate.specific_modulus <= limits.max_modulus) ||
      synth::damping::damping_fault(candidate.damping)) {
    return worst;
  }
  const double value = value_of(candidate).metric;
  return std::isfinite(value) ? std::min(value, worst) : worst;
}

void judge(MaterialEstimate& estimate, std::span<const features::Feature> features,
           const Objective& objective) {
  match(estimate, features, objective);
  find_ranges(estimate, objective);
  remark(estimate, features, objective);
}

}  // namespace carillon::eval::material
