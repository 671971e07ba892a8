#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "dataset/plan/plan.hpp"

namespace carillon::dataset::run {

/// What decides a task's results, as hashes. The journal keeps them, so that a later run knows
/// which results are still those of its configuration: an object or a strike more leaves all others
/// alone.
class TaskInputs {
 public:
  /// Both must outlive it.
  TaskInputs(const configuration::BuildConfig& config, const plan::BuildPlan& plan);

  /// @param samples  of a samples task: only the first so many of it
  std::string of(const plan::BuildTask& task, std::size_t samples) const;
  std::string of(const plan::BuildTask& task) const { return of(task, task.count); }

 private:
  std::string of_shape(std::size_t shape) const;

  const configuration::BuildConfig& config_;
  const plan::BuildPlan& plan_;
  std::string common_;
  std::vector<std::string> shapes_;
};

/// The resolved configuration without what may change over a folder: objects,
/// their materials, strikes for each, and limits.
std::string without_growth(const configuration::BuildConfig& config);

/// Journal entries sorted by what they are worth to a plan.
struct Standing {
  std::map<std::string, nlohmann::json> finished;  ///< entries of this plan's tasks as they are now
  /// Of samples tasks that have more samples than when they were done: the first of them are in the
  /// shard that is there.
  std::map<std::string, nlohmann::json> grown;
};

/// @param entries  of tasks whose files are there
Standing sort_entries(const configuration::BuildConfig& config, const plan::BuildPlan& plan,
                      const std::map<std::string, nlohmann::json>& entries);

}  // namespace carillon::dataset::run
