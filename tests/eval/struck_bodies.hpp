#pragma once

#include <cstdint>
#include <vector>

#include "eval/features/extract_features.hpp"
#include "eval/material/struck_modes.hpp"

namespace carillon::test {

/// Modes of objects that have closed forms, struck at a point, with an assumed material.
/// A free bar (Euler and Bernoulli), struck off its nodes.
eval::material::StruckModes free_bar(double specific_modulus, double length, double thickness,
                                     std::size_t count);
/// A plate with hinged edges (Navier), struck off its middle.
eval::material::StruckModes hinged_plate(double specific_modulus, double length, double width,
                                         double thickness, std::size_t count);
/// A free ring bending in its plane (Hoppe): both modes of a pair in one.
eval::material::StruckModes free_ring(double specific_modulus, double radius, double thickness,
                                      std::size_t count);

/// A clip and what can be extracted from it.
struct Recorded {
  std::vector<double> samples;
  eval::features::FeatureSet set;
};

struct RecordedOptions {
  double seconds = 1;
  double sample_rate = 44100;
  double snr = 200;           ///< of white noise, over the whole clip [dB]
  double missing = 0;         ///< fraction of the modes that do not sound
  bool random_phases = true;  ///< else cosines
  std::uint64_t seed = 1;
};

/// Damped tones summed sample by sample, from the onset at 0; with features as they are in truth.
Recorded record(const std::vector<eval::features::Feature>& tones,
                const RecordedOptions& options = {});

}  // namespace carillon::test
