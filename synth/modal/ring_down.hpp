#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/random.hpp"
#include "solvers/modes/modes.hpp"
#include "synth/material/material.hpp"
#include "synth/modal/contact_force.hpp"
#include "synth/modal/readout.hpp"
#include "synth/surface/outer_surface.hpp"

namespace carillon::synth::modal {

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
/// @throws InputError  no such face, or not a point of a face
PointFrame frame_at(const solvers::modes::ModeSurface& surface, const SurfacePoint& point);

/// Points uniform by area on the outer surface (faces of inner cavities left out). Each curved face
/// is cut into order^2 straight pieces; area and nearness are those of the pieces.
class SurfaceSampler {
 public:
  /// @throws InputError  no outer surface: no faces, or all look inward
  explicit SurfaceSampler(const solvers::modes::ModeSurface& surface);
  SurfacePoint sample(core::RandomStream& random) const;
  /// Nearest point of the outer surface to a position [m].
  SurfacePoint nearest(const Vec3& position) const;
  double area() const;  ///< [m^2], outer surface

 private:
  std::vector<surface::SurfaceTriangle> pieces_;
  std::vector<double> cumulative_;  ///< area up to and with each piece [m^2]
};

/// Mode shapes interpolated at a surface point: n modes x 3 [kg^-1/2].
/// @throws InputError  no such face, or not a point of a face
Eigen::MatrixX3d shapes_at(const solvers::modes::Modes& modes, const SurfacePoint& point);

/// One strike: where, which way, how hard, how long.
struct Strike {
  SurfacePoint point;
  Vec3 direction;      ///< unit vector the force points along (usually inward)
  double impulse = 0;  ///< [N s]
  ContactForce force;  ///< its course over time, per unit of impulse
};

/// A direction within `spread` [rad] of a unit vector, uniform on that cap of the sphere; draws
/// nothing for a spread of 0.
Vec3 spread_direction(const Vec3& axis, double spread, core::RandomStream& random);

/// What rings after a strike: oscillators q'' + 2 d q' + lambda q = excitation times a ContactForce
/// of unit impulse, and how their motion is heard.
struct RingDown {
  std::vector<double> eigenvalues;  ///< lambda = omega_n^2 [rad^2/s^2]
  std::vector<double> decay_rates;  ///< d [1/s]
  Eigen::VectorXd excitation;       ///< phi . impulse of modes [N s kg^-1/2]
  Readout readout;
};

/// Modes struck at a point.
/// @param readout  of the modes' motion, for example point_velocity() or monopole()
/// @throws InputError  sizes that do not match, a direction that is no unit vector, a value that is
///                     not finite
RingDown ring_down(const solvers::modes::Modes& modes, std::span<const double> decay_rates,
                   const Strike& strike, const Readout& readout);

/// -160 dB: below the step of any output.
inline constexpr double inaudible = 1e-8;

/// Samples of each row from t = 0 on, `count` per row, rows one after the other. Exact at the
/// sampling instants: during contact the forced response, then free decay, both in closed form;
/// over-critical modes as two real exponentials. Modes whose damped frequency is at or above
/// Nyquist are left out. With a duration of 0 the first sample is taken just after the impulse,
/// and the impulse (Dirac) in accelerations is left out: it has no samples. Delays are exact
/// fractions of a sample. Modes end early once all that ended modes could still have added is below
/// inaudible of the row's peak so far.
/// @throws InputError  sizes that do not match, values that are negative or not finite
std::vector<float> synthesize(const RingDown& rings, const ContactForce& force, double sample_rate,
                              std::size_t count);

/// Modes that sound: struck, heard in a row, and oscillating below half the sample rate or not at
/// all.
std::size_t sounding_modes(const RingDown& rings, double sample_rate);

/// Modes that a clip of this rate leaves out: oscillating at or above half of it.
std::size_t modes_above_nyquist(const RingDown& rings, double sample_rate);

/// T60 = ln(1000) / d [s].
double t60(double decay_rate);

/// Takes modes out of a sound: they are neither struck nor heard. The others keep their places.
void leave_out(RingDown& rings, std::span<const std::size_t> modes);

}  // namespace carillon::synth::modal
