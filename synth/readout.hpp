#pragma once

#include <Eigen/Core>
#include <complex>
#include <span>
#include <string>
#include <vector>

#include "solvers/modes.hpp"

namespace carillon::synth {

using solvers::Vec3;
struct SurfacePoint;

/// Air at 20 degrees C and 1013.25 hPa, dry (CRC Handbook of Chemistry and Physics).
inline constexpr double kAirDensity = 1.204;  ///< [kg/m^3]
inline constexpr double kSoundSpeed = 343.0;  ///< [m/s]

/// A place in free air where pressure is taken.
struct Listener {
  Vec3 position;  ///< [m], in the body's coordinates
};

/// How motion becomes an output: row r is the sum over coordinates i of displacement(r, i) q_i +
/// velocity(r, i) q_i' + acceleration(r, i) q_i'', delays[r] later. Coordinates are those of modes,
/// or of any other second-order oscillators. A matrix without entries is zero.
struct Readout {
  Eigen::MatrixXd displacement;
  Eigen::MatrixXd velocity;
  Eigen::MatrixXd acceleration;
  std::vector<double> delays;  ///< time of flight of each row [s]; its size is the number of rows
  std::string unit = "m/s";    ///< of every row: "m/s" (dry) or "Pa"
};

/// Adds to one coordinate of a row a transfer function of velocity, given at that coordinate's
/// free decay q ~ exp(s t), s = -d + i omega: output = Re(transfer s q). What the row then adds for
/// it is exact for the free decay and smooth in the forced motion.
/// @param transfer  output per velocity, e.g. [Pa s/m]; a coordinate that does not oscillate takes
///                  its real part
void add_transfer(Readout& readout, Eigen::Index row, Eigen::Index coordinate,
                  std::complex<double> transfer, double eigenvalue, double decay_rate);

/// The dry signal: velocity of a surface point along its outward normal, one row.
Readout point_velocity(const solvers::Modes& modes, const SurfacePoint& point);

/// Pressure at listeners from the body's volume velocity (monopole): p = rho_air dQ/dt / (4 pi r)
/// after r / c, with Q = sum over modes of q'_i times the integral of phi_i . n over the outer
/// surface and r measured from the centroid of the enclosed volume. Exact for bodies small against
/// the wavelength; bending modes have almost no volume velocity and are all but silent in it.
/// @throws InputError  a listener is nearer than the body's farthest point
Readout monopole(const solvers::Modes& modes, std::span<const Listener> listeners);

}  // namespace carillon::synth
