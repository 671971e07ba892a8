#pragma once

#include <Eigen/Core>
#include <vector>

#include "synth/modal/contact_force.hpp"
#include "synth/modal/readout.hpp"

namespace carillon::synth::contact {

/// A body as the air sees its rigid motion: along each of three axes a rigid sphere.
struct RigidSource {
  Vec3 centre = Vec3::Constant(0);                     ///< [m] centroid of the enclosed volume
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< unit vectors, one a column
  Vec3 radii = Vec3::Constant(0);  ///< [m] of the sphere that stands for motion along each axis
  double mass = 0;                 ///< [kg]
};

/// Semi-axes of the ellipsoid that has an outer surface's second moments of area, sqrt(3 moment)
/// (a sphere's are its radius), ascending.
/// @param axes  receives its axes, one a column, when not null
/// @throws InputError  no outer surface, or one of area zero
Vec3 surface_ellipsoid(const solvers::modes::ModeSurface& surface, Eigen::Matrix3d* axes = nullptr);

/// Radius of the sphere whose dipole at low frequencies is that of an ellipsoid in motion along
/// each of its axes: 2 pi a_i^3 = V (1 + k_i), with Lamb's added mass k_i = alpha_i /
/// (2 - alpha_i), alpha_i = abc integral of du / ((a_i^2 + u) Delta(u)) (Lamb, Hydrodynamics, 114).
Vec3 equivalent_radii(const Vec3& semi_axes);

/// @throws InputError  no outer surface, a mass that is not positive and finite
RigidSource rigid_source(const solvers::modes::ModeSurface& surface, double mass);

/// Whether a listener stands where a click is known: outside all three spheres, or on them.
bool hears_click(const RigidSource& source, const Vec3& listener);

/// Sound of the body's abrupt acceleration as a rigid whole (acceleration noise: Koss and Alfredson
/// 1973 for spheres, Chadwick, Zheng and James 2012 for bodies of any shape).
///
/// A rigid sphere of radius a with the acceleration A(t) along an axis radiates exactly
/// p = rho cos(theta) (G'(tau) / (c r) + G(tau) / r^2), tau = t - (r - a) / c, where
/// G'' + 2 (c/a) G' + 2 (c/a)^2 G = a c^2 A. Here A is the force's part along each axis over the
/// mass, the air carried along (half the sphere's air) included, and the three axes add up.
/// Rotation and the striker's own acceleration are left out.
///
/// Sample n is the mean pressure from (n - 1) / fs to n / fs: a click reaches far beyond the
/// Nyquist frequency, and the mean keeps it causal: samples before the sound can have arrived are
/// exactly zero.
///
/// @param impulse   [N s] of the force, in the body's coordinates
/// @param listener  [m], in the body's coordinates
/// @param begin     time of the strike [s], >= 0
/// @return `count` values [Pa]
/// @throws InputError  a listener inside one of the three spheres, values that are not finite or
///                     not physical, pressure beyond single precision
std::vector<float> acceleration_click(const RigidSource& source, const Vec3& impulse,
                                      const modal::ContactForce& force, const Vec3& listener,
                                      double sample_rate, std::size_t count, double begin = 0);

}  // namespace carillon::synth::contact
