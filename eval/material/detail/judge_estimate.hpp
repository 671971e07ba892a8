#pragma once

#include <span>

#include "eval/material/detail/coordinates.hpp"
#include "eval/material/estimate_material.hpp"

namespace carillon::eval::material {

/// What is minimised.
struct Objective {
  const Reference& reference;
  const StruckModes& modes;
  HeardMotion motion;
  Coordinates coordinates;
  StartOptions limits;

  MetricValue value_of(const Candidate& candidate) const;
  /// Finite for any coordinates: those beyond the limits or without numbers are the worst.
  double metric(std::span<const double> x) const;
};

/// Fills in how well an estimate is determined: matches, errors, ranges and remarks.
void judge(MaterialEstimate& estimate, std::span<const features::Feature> features,
           const Objective& objective);

}  // namespace carillon::eval::material
