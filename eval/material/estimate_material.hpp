#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/numbers.hpp"
#include "eval/damping/fit_damping.hpp"
#include "eval/features/extract_features.hpp"
#include "eval/material/hybrid_metric.hpp"
#include "eval/material/start_points.hpp"
#include "eval/material/struck_modes.hpp"

namespace carillon::eval::material {

struct MaterialOptions {
  damping::DampingLaw law;
  HeardMotion motion = HeardMotion::velocity;
  std::optional<double> contact_time;  ///< [s]; none: it is sought too
  std::size_t searches = 8;            ///< starts from which the metric is minimised
  StartOptions starts;
  MetricOptions metric;
};

/// A place where the metric has a minimum.
struct LocalMinimum {
  Candidate candidate;
  MetricValue value;
};

/// A feature and the mode that it is most similar to.
struct MatchedFeature {
  std::size_t feature = 0;
  std::size_t mode = 0;    ///< of the struck modes
  features::Feature tone;  ///< what the estimate makes of that mode
  double similarity = 0;
  bool near = false;  ///< within the match scale's distance in Bark
};

struct MaterialEstimate {
  Candidate candidate;
  MetricValue value;
  std::vector<LocalMinimum> minima;      ///< with specific moduli 1 % apart or more; the best first
  std::vector<MatchedFeature> matches;   ///< one for each feature
  std::vector<features::Feature> tones;  ///< what the estimate sounds like
  /// One standard error of ln(specific modulus), from how the matched features' frequencies spread
  /// about the modes'; infinite with fewer than two.
  double modulus_error = 0;
  double rms_cents = 0;  ///< distance of matched features and modes, weighted by prominence
  /// Between which values of each alpha alone the metric stays within a tenth of its minimum.
  std::vector<core::Range> ranges;
  std::size_t starts = 0;       ///< candidates that were compared as starts
  std::size_t evaluations = 0;  ///< of the metric
  bool converged = false;
  std::vector<std::string> remarks;  ///< how well it is determined, and what a user should know
};

/// Specific modulus, scale and damping of the material of one struck object from one recording
/// (Sterling 2019, section 3.3), by the modes of an assumed material, which are not solved again.
/// @param samples  of the recording that `set` was extracted from
/// @throws InputError  no features or fewer than parameters, no modes, a point where none is heard
MaterialEstimate estimate_material(std::span<const double> samples, const features::FeatureSet& set,
                                   const StruckModes& modes, const MaterialOptions& options);

}  // namespace carillon::eval::material
