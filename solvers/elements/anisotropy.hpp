#pragma once

#include <Eigen/Core>
#include <array>

#include "solvers/elements/elastic.hpp"

namespace carillon::solvers::elements {

/// The nine constants of an orthotropic solid. Pairs of axes stand in the order 23, 13, 12.
struct EngineeringConstants {
  std::array<double, 3> youngs_moduli{};   ///< E1, E2, E3 [Pa]
  std::array<double, 3> poisson_ratios{};  ///< nu_ij: minus the strain along j over that along i,
                                           ///< under a stress along i
  std::array<double, 3> shear_moduli{};    ///< [Pa]
};

/// Stiffness [the moduli's unit] in Voigt's order 11, 22, 33, 23, 13, 12 with shear strains of
/// engineers (twice those of the tensor).
Voigt orthotropic_stiffness(const EngineeringConstants& constants);
Voigt cubic_stiffness(double c11, double c12, double c44);
/// The sixfold axis is the third; C66 = (C11 - C12) / 2.
Voigt hexagonal_stiffness(double c11, double c12, double c13, double c33, double c44);
Voigt isotropic_stiffness(double youngs_modulus, double poisson_ratio);

/// A solid of any stiffness [Pa] and density [kg/m^3]. Its youngs_modulus and poisson_ratio are
/// those of a polycrystal of it, Hill's mean of Voigt's and Reuss's bounds (Hill 1952): what
/// contact and estimates take it for.
/// @note Any constants: elastic_fault() judges them.
Elastic anisotropic(const Voigt& stiffness, double density);

/// A stiffness in coordinates where the solid's own axes are the columns of a rotation.
Voigt rotated(const Voigt& stiffness, const Eigen::Matrix3d& axes);
/// The same of a solid; an isotropic one stays as it is.
Elastic rotated(const Elastic& solid, const Eigen::Matrix3d& axes);

}  // namespace carillon::solvers::elements
