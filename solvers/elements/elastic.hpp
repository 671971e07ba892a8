#pragma once

#include <optional>

#include "core/fault.hpp"

namespace carillon::solvers::elements {

/// Linear isotropic elasticity of one region.
struct Elastic {
  double youngs_modulus = 0;  ///< [Pa]
  double poisson_ratio = 0;
  double density = 0;  ///< [kg/m^3]
};

/// Rules: modulus and density are positive and finite, Poisson's ratio lies between -1 and 0.5.
std::optional<core::Fault> elastic_fault(const Elastic& material);

/// @throws core::InputError  a rule is broken
void check_elastic(const Elastic& material);

}  // namespace carillon::solvers::elements
