#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "dataset/run/plan_summary.hpp"
#include "dataset/run/schedule.hpp"
#include "dataset/sweep/load_sweep.hpp"

namespace carillon::dataset::sweep {

/// Counts of what variants share.
struct SharingCounts {
  std::size_t objects = 0;             ///< modes tasks of all variants
  std::size_t meshes = 0, solves = 0;  ///< that are different from each other
  double seconds_saved = 0;            ///< estimated, of modes tasks that read the cache instead
};

/// What `carillon plan` tells of a sweep.
struct SweepPlan {
  std::vector<run::PlanSummary> variants{};
  SharingCounts shared{};
  std::size_t samples = 0;
  double rank_seconds_alone = 0;  ///< estimated, of one rank, if nothing were shared [s]
  double memory_per_rank = 0, disk_bytes = 0;      ///< as in PlanSummary
  std::optional<run::SimulatedBuild> simulated{};  ///< where ranks were asked for
  double rank_seconds() const { return rank_seconds_alone - shared.seconds_saved; }
};
SweepPlan plan_sweep(const LoadedSweep& loaded, const run::ScheduleOptions& schedule);

nlohmann::ordered_json to_json(const SweepPlan& plan, const LoadedSweep& loaded);
/// For a person.
std::string plan_text(const SweepPlan& plan, const LoadedSweep& loaded);

/// What `carillon plan` says of a configuration, of one dataset or a sweep.
struct PlanReport {
  std::string text;  ///< for a person
  nlohmann::json document;
};

/// Loads a configuration and plans it; runs nothing.
/// @param schedule  also simulated, where it names ranks
/// @param comm      all of it load the configuration, the first one plans: empty on the others
/// @throws ConfigError, InputError  on every rank
PlanReport plan_configuration(const run::BuildOptions& options,
                              const run::ScheduleOptions& schedule, MPI_Comm comm);

}  // namespace carillon::dataset::sweep
