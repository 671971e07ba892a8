#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "eval/material/estimate_material.hpp"

namespace carillon::eval::material {

/// A strike on an object, recorded.
struct StruckRecording {
  std::span<const double> samples;
  const features::FeatureSet* set = nullptr;  ///< extracted from them
  StruckModes modes;  ///< as this strike strikes them and this recording hears them
};

struct JointEstimate {
  Candidate candidate;  ///< that fits all recordings best; one scale for all
  double metric = 0;    ///< mean over the recordings that have features
  /// Of each recording alone; none where it has too few features.
  std::vector<std::optional<MaterialEstimate>> alone;
  std::size_t evaluations = 0;  ///< of the metric of one recording, those of `alone` not counted
  std::vector<std::string> remarks;
};

/// The material of one object from several recordings of it, all taken at one gain: the mean of
/// their hybrid metrics (hybrid_metric.hpp) is minimised, from the minima of each recording alone.
/// @throws InputError  no recordings, or none that a material can be estimated from (says why)
JointEstimate estimate_jointly(std::span<const StruckRecording> recordings,
                               const MaterialOptions& options);

}  // namespace carillon::eval::material
