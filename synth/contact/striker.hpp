#pragma once

#include <string>
#include <vector>

#include "synth/modal/ring_down.hpp"

namespace carillon::synth::contact {

/// What strikes: an elastic body that meets the other with a rounded end.
struct Striker {
  std::string name;
  double mass = 0;            ///< [kg]
  double radius = 0;          ///< [m] of the rounded end
  double youngs_modulus = 0;  ///< [Pa]; may be infinite
  double poisson_ratio = 0;
  double restitution = 1;  ///< rebound speed over approach speed, 0 to 1
  std::string source;
  double density = 0;  ///< [kg/m^3] of a ball, whose mass it gives; 0: no ball
};

/// `metal`, `wood`, `rubber` and `finger`. Elastic constants of metal and wood are those of the
/// presets `steel` and `wood`; every other value is assumed, and `source` says so.
const std::vector<Striker>& preset_strikers();
/// @throws InputError  unknown; names the nearest
const Striker& preset_striker(const std::string& name);
/// @throws InputError  mass, radius or modulus not positive, nu outside (-1, 0.5], restitution
///                     outside [0, 1]
void check_striker(const Striker& striker);

/// Mass of a ball [kg].
double ball_mass(double radius, double density);

/// What the striker meets.
struct StruckBody {
  double mass = 0;            ///< [kg]; infinite: held fast
  double youngs_modulus = 0;  ///< [Pa]; may be infinite
  double poisson_ratio = 0;
  double curvature = 0;  ///< [1/m] mean curvature at the point, > 0 where the body bulges; 0: flat
};

/// Mean curvature [1/m] of the curved face that a point lies on, from the turn of its normal over
/// half the face: 1 / a on a sphere of radius a, 0 on faces of order 1.
/// @throws InputError  no such face, or not a point of a face
double mean_curvature(const solvers::modes::ModeSurface& surface, const modal::SurfacePoint& point);

/// Hertz's contact of two elastic bodies at an approach speed.
struct HertzContact {
  double mass = 0;        ///< m = 1 / (1/m_striker + 1/m_body) [kg]
  double radius = 0;      ///< R = 1 / (1/R_striker + curvature) [m]
  double modulus = 0;     ///< E* = 1 / ((1 - nu1^2) / E1 + (1 - nu2^2) / E2) [Pa]
  double duration = 0;    ///< T = 2.868 (m^2 / (R E*^2 v))^(1/5) [s]
  double approach = 0;    ///< deepest approach (15 m v^2 / (16 sqrt(R) E*))^(2/5) [m]
  double peak_force = 0;  ///< 4/3 E* sqrt(R) approach^(3/2) [N]; infinite for a rigid contact
  double impulse = 0;     ///< m v (1 + restitution) [N s]
};

/// T over (m^2 / (R E*^2 v))^(1/5): 4/5 (15/16)^(2/5) B(2/5, 1/2), from m x'' = -4/3 E* sqrt(R)
/// x^(3/2) (Johnson 1985, eq. 11.24). In terms of the deepest approach, T = 2.943 approach / v.
double hertz_constant();

/// A body no striker fits into (curvature below -1 / R_striker) is met as if 1/R were a tenth of
/// the striker's. At speed 0 nothing is struck: impulse, force and duration are 0. A rigid contact
/// (both moduli infinite) has duration 0. Rotation of either body is left out.
/// @throws InputError  a speed that is negative or not finite, values check_striker() refuses, a
///                     body without mass or stiffness, a duration beyond a double
HertzContact hertz_contact(const Striker& striker, const StruckBody& body, double speed);

}  // namespace carillon::synth::contact
