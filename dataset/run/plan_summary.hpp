#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "dataset/plan/solver_plan.hpp"
#include "dataset/run/build.hpp"
#include "dataset/run/expected_bytes.hpp"
#include "scene/scene.hpp"

namespace carillon::dataset::run {

/// What `carillon plan` tells of a build.
struct PlanSummary {
  std::string name{};
  std::size_t shapes = 0, samples = 0;
  std::size_t modes_tasks = 0, samples_tasks = 0;
  std::map<int, std::size_t> tasks_of_width{};      ///< by ranks of a task's group
  std::vector<std::string> shared_between_parts{};  ///< objects that all parts of the split share
  std::vector<plan::SolverChoice> solver{};
  std::vector<scene::PlannedEffect> effects{};
  double rank_seconds = 0;     ///< estimated, of one rank [s]
  double memory_per_rank = 0;  ///< estimated peak [byte]
  ExpectedBytes disk{};        ///< of all files
};
PlanSummary summarise_plan(const LoadedBuild& build);

/// docs/guide.md names the fields.
nlohmann::json to_json(const PlanSummary& plan);
/// For a person.
std::string plan_text(const PlanSummary& plan);

}  // namespace carillon::dataset::run
