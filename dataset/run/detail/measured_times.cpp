#include "dataset/run/detail/measured_times.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/json.hpp"
#include "dataset/plan/task_times.hpp"
#include "dataset/run/build.hpp"
#include "dataset/run/costs.hpp"
#include "mpi/journal.hpp"

namespace carillon::dataset::run {

using nlohmann::json;

namespace {

/// Kinds whose estimates are held against what tasks took: groups and single ranks together.
std::string ratio_of(const std::string& kind) {
  return kind == "modes of groups" ? "modes" : kind;
}

/// Without what others took of the processors, which all ranks of a group share evenly.
double own_seconds(const mpi::TaskTimes& times) {
  return std::max(0.0, times.seconds - times.queued / std::max(1, times.width));
}

MeasuredTimes from_trace(const std::filesystem::path& path) {
  MeasuredTimes times;
  if (!std::filesystem::exists(path)) return times;
  try {
    for (const plan::TaskRow& row : plan::task_rows(core::read_json(path))) {
      times[row.task] = {row.estimate, own_seconds(row.times), row.kind};
    }
  } catch (const json::exception& error) {
    throw core::InputError(
        fmt::format("{} is no trace of a build: {}", path.string(), error.what()));
  }
  return times;
}

/// Seconds by key.
std::map<std::string, double> from_journal(const std::filesystem::path& path) {
  std::map<std::string, double> seconds;
  for (const json& entry : mpi::read_journal(path).entries) {
    if (entry.value("ok", false) && entry.contains("seconds")) {
      // Earlier versions kept no other times.
      const json& times = entry.contains("times") ? entry.at("times") : entry;
      const std::string task = entry.at("task");
      seconds[task] = own_seconds(plan::task_row(task, times).times);
    }
  }
  return seconds;
}

/// What this program estimates for the tasks of a dataset's configuration [s], by key.
MeasuredTimes estimates_of(const std::filesystem::path& configuration) {
  MeasuredTimes estimates;
  const configuration::BuildConfig config =
      configuration::read_build_config(core::read_file(configuration), configuration.string(), {});
  for (const mpi::Task& task : board_tasks(plan::make_plan(config), config)) {
    estimates[task.key] = {task.cost / task.width, 0, task.kind};
  }
  return estimates;
}

/// Another version may have estimated otherwise than this one does.
void use_own_estimates(const std::filesystem::path& configuration, MeasuredTimes& times) {
  try {
    for (const auto& [key, own] : estimates_of(configuration)) {
      const auto found = times.find(key);
      if (found != times.end()) found->second.estimate = own.estimate;
    }
  } catch (const core::Error&) {
    // Its mesh files are not beside it any more, or its keys are another version's: the trace's
    // own estimates stand.
  }
}

}  // namespace

MeasuredTimes read_measured_times(const std::filesystem::path& path) {
  const bool is_folder = std::filesystem::is_directory(path);
  const std::filesystem::path folder = is_folder ? path : path.parent_path();
  if (!std::filesystem::exists(path)) {
    throw core::FileError(fmt::format("{}: there is no such folder or file", path.string()),
                          "--trace takes the folder of a dataset or sweep, or its trace.json");
  }
  MeasuredTimes times = from_trace(is_folder ? folder / "trace.json" : path);
  const std::filesystem::path journal = folder / "journal.jsonl";
  const std::filesystem::path configuration = folder / "configuration.yaml";
  if (times.empty() && std::filesystem::exists(journal) && std::filesystem::exists(configuration)) {
    const MeasuredTimes estimates = estimates_of(configuration);
    for (const auto& [key, seconds] : from_journal(journal)) {
      const auto found = estimates.find(key);
      if (found == estimates.end()) continue;
      times[key] = {found->second.estimate, seconds, found->second.kind};
    }
  } else if (std::filesystem::exists(configuration)) {
    use_own_estimates(configuration, times);
  }
  if (times.empty()) {
    throw core::InputError(fmt::format("{} tells of no finished task", path.string()),
                           "--trace takes the folder of a dataset or sweep, or its trace.json");
  }
  return times;
}

TaskSeconds expected_seconds(const std::vector<mpi::Task>& tasks, const MeasuredTimes& measured) {
  struct Sums {
    double estimate = 0, seconds = 0;
  };
  std::map<std::string, Sums> sums{{"modes", {}}, {"samples", {}}};
  for (const mpi::Task& task : tasks) sums[ratio_of(task.kind)];
  for (const auto& [key, time] : measured) {
    const auto sum = sums.find(ratio_of(time.kind));
    if (sum == sums.end()) continue;
    sum->second.estimate += time.estimate;
    sum->second.seconds += time.seconds;
  }
  TaskSeconds out;
  for (const auto& [kind, sum] : sums) {
    out.ratio[kind] = sum.estimate > 0 ? sum.seconds / sum.estimate : 1;
  }
  for (const mpi::Task& task : tasks) {
    const double estimate = task.cost / task.width;
    const auto found = measured.find(task.key);
    const bool same =
        found != measured.end() && std::abs(found->second.estimate - estimate) <= 1e-6 * estimate;
    out.measured += same ? 1 : 0;
    out.seconds.push_back(same ? found->second.seconds
                               : estimate * out.ratio.at(ratio_of(task.kind)));
  }
  return out;
}

}  // namespace carillon::dataset::run
