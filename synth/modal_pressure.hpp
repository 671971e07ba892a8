#pragma once

#include <span>

#include "synth/readout.hpp"

namespace carillon::synth {

/// Pressure of modes at listeners in the frequency domain.
struct ModalPressure {
  /// Complex pressure per modal acceleration at each mode's own angular frequency omega_n, with
  /// exp(i omega t) (so that waves leave as exp(-i k r)) and the time of flight taken out:
  /// p(t) = Re(pressure q''(t - delay)); listeners x modes [Pa kg^1/2 s^2/m].
  Eigen::MatrixXcd pressure;
  std::vector<double> delays;  ///< distance from the centroid over the speed of sound [s]
};

/// Pressure as real gains: output = Re(pressure s^2 q) at the free decay's s = -d + i omega, one
/// row per listener. The part in phase with the acceleration goes with it while the mode is forced,
/// too; a mode that does not oscillate has that part alone.
/// @throws InputError  not one decay rate for each mode
Readout pressure_readout(const ModalPressure& pressure, const solvers::Modes& modes,
                         std::span<const double> decay_rates);

/// omega_n / c of each mode [1/m].
/// @throws InputError  an eigenvalue that is negative or not finite, a shape that is not finite
std::vector<double> wavenumbers(const solvers::Modes& modes);

}  // namespace carillon::synth
