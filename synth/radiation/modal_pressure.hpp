#pragma once

#include <span>

#include "synth/modal/readout.hpp"

namespace carillon::synth::radiation {

/// Pressure of modes at listeners in the frequency domain.
struct ModalPressure {
  /// Complex pressure per modal acceleration at each mode's own angular frequency omega_n, with
  /// exp(i omega t) (so that waves leave as exp(-i k r)) and the time of flight taken out:
  /// p(t) = Re(pressure q''(t - delay)); listeners x modes [Pa kg^1/2 s^2/m].
  Eigen::MatrixXcd pressure;
  std::vector<double> delays;  ///< distance from the centroid over the speed of sound [s]
};

/// Pressure as real gains, one row per listener: the transfer function P(s) from acceleration to
/// pressure is continued from P(i omega_n) as Re P + (Im P / omega_n) s, which is what a source
/// that is small against the wavelength has (monopole, near and far field of a dipole), so that
/// output = Re P q'' + (Im P / omega_n) q''', q''' = F' - 2 d q'' - lambda q'. The free decay is
/// Re(P s^2 q) but for a fraction of d / omega_n. Under a force that is slow against the mode
/// pressure follows F'' and F'''; of one that is fast the rate F' is left out (slow_fraction()), as
/// no body is small against its waves. Gains are continuous in d; beyond critical damping d counts
/// as omega_n.
/// @throws InputError  not one decay rate for each mode
modal::Readout pressure_readout(const ModalPressure& pressure, const solvers::modes::Modes& modes,
                                std::span<const double> decay_rates);

/// omega_n / c of each mode [1/m].
/// @throws InputError  an eigenvalue that is negative or not finite, a shape that is not finite
std::vector<double> wavenumbers(const solvers::modes::Modes& modes);

}  // namespace carillon::synth::radiation
