#pragma once

#include <span>
#include <vector>

#include "solvers/modes/modes.hpp"

namespace carillon::synth::surface {

/// A free body's motion as a whole, whose six modal coordinates have no stiffness.
struct RigidBody {
  double mass = 0;                                     ///< [kg]
  Vec3 centre = Vec3::Zero();                          ///< of mass [m]
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< principal, as columns
  Vec3 inertia = Vec3::Zero();                         ///< about them [kg m^2]
};

/// Centre and inertia by the volume moments of the surface (tetrahedra under its straight pieces,
/// cavities taken off), scaled to the mass of the modes: regions of different density count as one
/// (what has several takes region_moments()).
/// @throws InputError  no mass, no volume
RigidBody rigid_body(const solvers::modes::Modes& modes);

/// Moments of a region's volume.
struct RegionMoments {
  double volume = 0;                                 ///< [m^3]
  Vec3 centroid = Vec3::Zero();                      ///< [m]
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();  ///< mean of r r^T about the centroid [m^2]
};

/// Of each region of a mesh, its elements' edges taken as straight.
/// @throws InputError  a region without volume
std::vector<RegionMoments> region_moments(const solvers::mesh::TetMesh& mesh);

/// The same of regions of different density, scaled to the mass.
/// @param densities  of each region [kg/m^3]
/// @throws InputError  no mass, numbers that do not match, densities without weight
RigidBody rigid_body(std::span<const RegionMoments> regions, std::span<const double> densities,
                     double mass);

/// Mass-normalised rigid shapes at a point [kg^-1/2]: three translations e_k / sqrt(m), then three
/// rotations a_k x r / sqrt(I_k) about the principal axes a_k.
Eigen::Matrix<double, 6, 3> rigid_shapes_at(const RigidBody& body, const Vec3& position);

}  // namespace carillon::synth::surface
