#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "eval/damping/fit_damping.hpp"
#include "eval/material/hybrid_metric.hpp"
#include "eval/material/struck_modes.hpp"

namespace carillon::eval::material {

struct StartOptions {
  std::size_t samples = 8;    ///< of the dominant features; the first holds all of them
  double fraction = 0.5;      ///< of the dominant features in a sample
  std::size_t dominant = 24;  ///< features that count as dominant
  std::size_t paired = 12;    ///< features, and ...
  std::size_t modes = 40;     ///< ... modes that are paired for a specific modulus
  std::uint64_t seed = 1;
  double min_modulus = 1e4;  ///< specific modulus [m^2/s^2]: soft rubber
  double max_modulus = 1e9;  ///< beyond diamond
};

/// Where c(lambda) takes a value within low < lambda < high, ascending: one root where the model is
/// monotone, otherwise all that lie between points a sixteenth of an octave of frequency apart.
std::vector<double> eigenvalues_damped_by(const std::function<double(double)>& c, double value,
                                          double low, double high);

/// Damping models by least squares on samples of the dominant features, drawn without replacement
/// with their prominences as weights (Sterling 2019, 3.3.2).
/// @throws InputError  fewer features than parameters, or no sample that can be fitted
std::vector<synth::damping::DampingModel> damping_starts(
    std::span<const features::Feature> features, const damping::DampingLaw& law,
    const MatchScale& scale, const StartOptions& options);

struct Start {
  Candidate candidate;
  double match = 0;        ///< product of match ratios
  std::size_t sample = 0;  ///< which of the damping models
};

/// Candidates for every damping model and pair of a dominant feature and a mode, most similar
/// first. Specific moduli are those that damp the mode like the feature, c(gamma lambda) = 2 d
/// (Sterling 2019, Fig. 3.1), and the one that tunes the mode to the feature (3.3.1); the scale
/// makes their amplitudes equal.
std::vector<Start> start_points(std::span<const features::Feature> features,
                                const StruckModes& modes,
                                const std::vector<synth::damping::DampingModel>& damping,
                                double contact_time, HeardMotion motion, const Reference& reference,
                                const StartOptions& options);

}  // namespace carillon::eval::material
