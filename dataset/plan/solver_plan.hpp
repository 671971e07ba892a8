#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "dataset/configuration/configuration.hpp"

namespace carillon::dataset::plan {

/// One thing of what will solve the objects of a build, and why.
struct SolverChoice {
  std::string name{};
  nlohmann::json value{};  ///< for programs (SI); null where it is chosen for each object
  std::string text{};      ///< the value for a person
  std::string reason{};
};

/// order, element_size, max_elements, pitch_target, band, max_modes, eigen_solver, linear_solver,
/// memory_limit.
std::vector<SolverChoice> plan_solver(const configuration::BuildConfig& config);

}  // namespace carillon::dataset::plan
