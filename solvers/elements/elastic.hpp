#pragma once

namespace carillon::solvers::elements {

/// Linear isotropic elasticity of one region.
struct Elastic {
  double youngs_modulus = 0;  ///< [Pa]
  double poisson_ratio = 0;
  double density = 0;  ///< [kg/m^3]
};

}  // namespace carillon::solvers::elements
