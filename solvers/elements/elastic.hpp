#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/fault.hpp"

namespace carillon::solvers::elements {

/// A symmetric matrix between strains and stresses in Voigt's order 11, 22, 33, 23, 13, 12.
using Voigt = Eigen::Matrix<double, 6, 6>;

/// Linear elasticity of one region: isotropic, or of any anisotropy (anisotropy.hpp).
struct Elastic {
  double youngs_modulus = 0;  ///< [Pa]
  double poisson_ratio = 0;
  double density = 0;  ///< [kg/m^3]
  /// Stiffness over youngs_modulus, in the object's axes; then that modulus and Poisson's ratio are
  /// an isotropic mean. None: isotropic.
  std::optional<Voigt> anisotropy = {};
};

/// Whether two solids differ in youngs_modulus and density at most, to rounding: their modes are
/// rescaled ones of each other.
bool same_law(const Elastic& a, const Elastic& b);

/// What tells one solid from another: the three constants, then the entries of an anisotropy.
std::vector<double> identity_of(const Elastic& material);

/// Rules: modulus and density are positive and finite, Poisson's ratio lies between -1 and 0.5, an
/// anisotropic stiffness is positive definite.
std::optional<core::Fault> elastic_fault(const Elastic& material);

/// @throws core::InputError  a rule is broken
void check_elastic(const Elastic& material);

}  // namespace carillon::solvers::elements
