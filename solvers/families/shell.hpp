#pragma once

#include <functional>

#include "solvers/families/family.hpp"
#include "solvers/families/profile.hpp"

namespace carillon::solvers {

/// A closed-bottom shell of revolution about z: a wall laid half to each side of a profile that
/// begins on the axis with a straight line.
struct Shell {
  Profile profile;
  std::function<double(double s)> wall;  ///< thickness [m] at a place of the profile
  double thinnest;                       ///< smallest wall [m]
  double thickest;                       ///< largest wall [m]
};

/// @throws InputError  the wall is thicker than the profile's curvature lets it be
void check_shell(const GeneratedShape& shape, const Shell& shell);

MeshResult mesh_shell(const Shell& shell, const MeshOptions& options);

}  // namespace carillon::solvers
