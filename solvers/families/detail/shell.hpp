#pragma once

#include <functional>
#include <vector>

#include "solvers/families/detail/profile.hpp"
#include "solvers/families/family.hpp"

namespace carillon::solvers::families {

/// A closed-bottom shell of revolution about z: a wall laid half to each side of a profile that
/// begins on the axis with a straight line.
struct Shell {
  Profile profile;
  std::function<double(double s)> wall;  ///< thickness [m] at a place of the profile
  double thinnest;                       ///< smallest wall [m]
  double thickest;                       ///< largest wall [m]
  /// Places s inside segments where the wall's thickness is not smooth.
  std::vector<double> wall_joints = {};
};

/// @throws InputError  the wall is thicker than the profile's curvature lets it be
void check_shell(const mesh::GeneratedShape& shape, const Shell& shell);

mesh::MeshResult mesh_shell(const Shell& shell, const mesh::MeshOptions& options);

/// Section with a block for each segment of the profile, and one of its own along the rim.
mesh::Meridian shell_meridian(const Shell& shell);

}  // namespace carillon::solvers::families
