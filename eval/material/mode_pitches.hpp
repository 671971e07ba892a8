#pragma once

#include <optional>
#include <span>
#include <vector>

#include "solvers/modes/modes.hpp"
#include "synth/modal/ring_down.hpp"

namespace carillon::eval::material {

/// The pitches of an object's modes at one Poisson's ratio, and how well they are heard.
struct ModePitches {
  double poisson_ratio = 0;
  double specific_modulus = 0;      ///< E / density that they are of [m^2/s^2]
  std::vector<double> frequencies;  ///< undamped [Hz], ascending
  std::vector<double> errors;       ///< estimated distance above the body's own pitch [cents]
  /// How well each mode is heard, 0 to 1; modes that a tone cannot tell apart share one weight.
  std::vector<double> weights;
  double complete_to_hz = 0;  ///< no mode below is missing
};

/// Pitches of solved modes. Without a strike, a mode is as audible as it is on average over points
/// of the outer surface, struck along the normal there: modes that move no point along its normal
/// are not heard wherever it is struck.
/// @param specific_modulus  that they were solved with [m^2/s^2]
/// @param strike            where the object was struck, if that is known
ModePitches mode_pitches(const solvers::modes::Modes& modes, double specific_modulus,
                         double poisson_ratio, const std::optional<synth::modal::Strike>& strike);

/// Weights of modes from the levels that they are heard with.
/// @param frequencies  [Hz], ascending
/// @param amplitudes   of each mode, of any unit, not negative; points in columns: modes x points
std::vector<double> audibility(std::span<const double> frequencies,
                               const Eigen::MatrixXd& amplitudes);

/// Pitches at a Poisson's ratio between two others of the same object and specific modulus, linear
/// from the lowest mode on (modes that cross change places; within steps of 0.05 of the ratio that
/// costs a few cents, elsewhere it is right to 0.2).
ModePitches between(const ModePitches& low, const ModePitches& high, double poisson_ratio);

}  // namespace carillon::eval::material
