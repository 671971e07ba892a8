#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "dataset/plan/plan.hpp"

namespace carillon::dataset::plan {

/// One thing of what will solve the objects of a build, and why.
struct SolverChoice {
  std::string name{};
  nlohmann::json value{};  ///< for programs (SI); null where it is chosen for each object
  std::string text{};      ///< the value for a person
  std::string reason{};
};

/// axisymmetric and tetrahedra (how many shapes each solves), where some are tuned how many, band,
/// max_modes, pitch_target; and where there are tetrahedra order, element_size, max_elements,
/// edge_layers, max_unknowns, eigen_solver, linear_solver, mirror_planes, memory_limit.
std::vector<SolverChoice> plan_solver(const configuration::BuildConfig& config,
                                      const BuildPlan& plan);

}  // namespace carillon::dataset::plan
