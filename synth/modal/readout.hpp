#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <string>
#include <vector>

#include "solvers/modes/modes.hpp"

namespace carillon::synth::modal {

struct SurfacePoint;

/// Air at 20 degrees C and 1013.25 hPa, dry (CRC Handbook of Chemistry and Physics).
inline constexpr double air_density = 1.204;     ///< [kg/m^3]
inline constexpr double speed_of_sound = 343.0;  ///< [m/s]

/// A place in free air where pressure is taken.
struct Listener {
  Vec3 position;  ///< [m], in the body's coordinates
};

/// How motion becomes an output: row r is the sum over coordinates i of displacement(r, i) q_i +
/// velocity(r, i) q_i' + acceleration(r, i) q_i'' + force_rate(r, i) F_i', delays[r] later, where
/// F_i' is the rate of the force on the coordinate as far as that is slow against it
/// (slow_fraction()). Coordinates are those of modes, or of any other second-order oscillators. A
/// matrix without entries is zero.
struct Readout {
  Eigen::MatrixXd displacement;
  Eigen::MatrixXd velocity;
  Eigen::MatrixXd acceleration;
  Eigen::MatrixXd force_rate;
  std::vector<double> delays;  ///< time of flight of each row [s]; its size is the number of rows
  std::string unit = "m/s";    ///< of every row: "m/s" (dry) or "Pa"
};

/// The four matrices, for what treats them alike.
inline std::array<Eigen::MatrixXd*, 4> gains_of(Readout& readout) {
  return {&readout.displacement, &readout.velocity, &readout.acceleration, &readout.force_rate};
}
inline std::array<const Eigen::MatrixXd*, 4> gains_of(const Readout& readout) {
  return {&readout.displacement, &readout.velocity, &readout.acceleration, &readout.force_rate};
}

/// The dry signal: velocity of a surface point along its outward normal, one row.
Readout point_velocity(const solvers::modes::Modes& modes, const SurfacePoint& point);

/// Pressure at listeners from the body's volume velocity (monopole): p = rho_air dQ/dt / (4 pi r)
/// after r / c, with Q = sum over modes of q'_i times the integral of phi_i . n over the outer
/// surface and r measured from the centroid of the enclosed volume. Exact for bodies small against
/// the wavelength; bending modes have almost no volume velocity and are all but silent in it.
/// @throws InputError  a listener is nearer than the body's farthest point
Readout monopole(const solvers::modes::Modes& modes, std::span<const Listener> listeners);

}  // namespace carillon::synth::modal
