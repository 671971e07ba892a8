#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/random.hpp"
#include "solvers/modes.hpp"
#include "synth/material.hpp"

namespace carillon::synth {

using solvers::Vec3;

/// A point on the surface: a face and barycentric coordinates on it.
struct SurfacePoint {
  std::int32_t face = 0;
  Eigen::Vector3d barycentric = {1, 0, 0};
};

/// Position [m] and outward unit normal of the curved surface at a point.
struct PointFrame {
  Vec3 position;
  Vec3 normal;
};
PointFrame frame_at(const solvers::ModeSurface& surface, const SurfacePoint& point);

/// Points uniform by area on the outer surface (faces of inner cavities left out).
class SurfaceSampler {
 public:
  explicit SurfaceSampler(const solvers::ModeSurface& surface);
  SurfacePoint sample(core::RandomStream& random) const;
  /// Nearest point of the outer surface to a position [m].
  SurfacePoint nearest(const Vec3& position) const;
  double area() const;  ///< [m^2], outer surface

 private:
  solvers::ModeSurface surface_;
  std::vector<double> cumulative_;       ///< area up to each straight piece
  std::vector<std::int32_t> faces_;      ///< face of each piece
  std::vector<std::array<Eigen::Vector3d, 3>> corners_;  ///< barycentric corners of each piece
};

/// Mode shapes interpolated at a surface point: n modes x 3 [kg^-1/2].
Eigen::MatrixX3d shapes_at(const solvers::Modes& modes, const SurfacePoint& point);

/// One blow: where, which way, how hard, how long. The contact force is a raised cosine of
/// duration `contact_time` whose integral is `impulse`.
struct Strike {
  SurfacePoint point;
  Vec3 direction;             ///< unit vector the force points along (usually inward)
  double impulse = 0;         ///< [N s]
  double contact_time = 0;    ///< [s]; 0: an ideal impulse
};

/// Where the sound is taken: nothing (the velocity of the struck point along its outward normal
/// [m/s]) or a listener in free air (pressure [Pa]).
struct Listener {
  Vec3 position;  ///< [m], in the body's coordinates
};

/// What rings after a strike: one damped oscillation per mode.
struct RingDown {
  std::vector<double> eigenvalues;  ///< lambda = omega_n^2 [rad^2/s^2]
  std::vector<double> decay_rates;  ///< d [1/s]
  /// What a unit modal impulse response contributes to the output, one row per listener (a single
  /// row when there is none): (phi . F)(phi . n) for the dry signal, impulse included.
  Eigen::MatrixXd gains;
  std::vector<double> delays;  ///< time of flight of each row [s]
  bool pressure = false;       ///< rows are pressure [Pa] (modal acceleration drives them),
                               ///< otherwise velocity [m/s]
};

/// Decay rates d [1/s] of every mode: c_i = sum over regions of alpha1 kinetic_share +
/// alpha2 lambda strain_share, d = c / 2 (Sterling 2019, eq. 2.11; exact for Rayleigh damping that
/// differs between regions as far as the damping stays diagonal).
std::vector<double> decay_rates(const solvers::Modes& modes,
                                std::span<const RayleighDamping> regions);

/// The dry signal of a strike, or the pressure at listeners from the body's volume velocity
/// (monopole): p = rho_air dQ/dt / (4 pi r) after r / c. Exact for bodies small against the
/// wavelength; bending modes have no volume velocity and are silent in it.
RingDown ring_down(const solvers::Modes& modes, std::span<const double> decay_rates,
                   const Strike& strike, std::span<const Listener> listeners);

/// Samples of each row from t = 0 on, `count` per row, rows one after the other. Exact at the
/// sampling instants: during contact the forced response, then free decay, both in closed form;
/// over-critical modes as two real exponentials. Modes at or above Nyquist are left out.
/// @param dropped  number of modes left out, when not null
std::vector<float> synthesize(const RingDown& rings, double contact_time, double sample_rate,
                              std::size_t count, int* dropped = nullptr);

/// T60 = ln(1000) / d [s].
double t60(double decay_rate);

}  // namespace carillon::synth
