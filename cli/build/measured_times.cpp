#include "cli/build/measured_times.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/build/costs.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "mpi/journal.hpp"

namespace carillon::cli {

using nlohmann::json;

namespace {

std::string kind_of(const std::string& key) {
  return key.substr(0, key.find('/'));
}

MeasuredTimes from_trace(const std::filesystem::path& path) {
  MeasuredTimes times;
  if (!std::filesystem::exists(path)) return times;
  try {
    const json document = json::parse(core::read_file(path));
    for (const json& task : document.value("tasks", json::array())) {
      times[task.at("task")] = {task.at("estimate_s"), task.at("seconds")};
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
      seconds[entry.at("task")] = entry.at("seconds");
    }
  }
  return seconds;
}

/// What this program estimates for the tasks of a dataset's configuration [s], by key.
std::map<std::string, double> estimates_of(const std::filesystem::path& configuration) {
  std::map<std::string, double> estimates;
  const BuildConfig config =
      read_build_config(core::read_file(configuration), configuration.string(), {});
  for (const mpi::Task& task : board_tasks(make_plan(config), config)) {
    estimates[task.key] = task.cost / task.width;
  }
  return estimates;
}

/// Another version may have estimated otherwise than this one does.
void use_own_estimates(const std::filesystem::path& configuration, MeasuredTimes& times) {
  try {
    for (const auto& [key, estimate] : estimates_of(configuration)) {
      const auto found = times.find(key);
      if (found != times.end()) found->second.estimate = estimate;
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
                          "--trace takes the folder of a dataset, or its trace.json");
  }
  MeasuredTimes times = from_trace(is_folder ? folder / "trace.json" : path);
  const std::filesystem::path journal = folder / "journal.jsonl";
  const std::filesystem::path configuration = folder / "configuration.yaml";
  if (times.empty() && std::filesystem::exists(journal) && std::filesystem::exists(configuration)) {
    const std::map<std::string, double> estimates = estimates_of(configuration);
    for (const auto& [key, seconds] : from_journal(journal)) {
      const auto found = estimates.find(key);
      if (found != estimates.end()) times[key] = {found->second, seconds};
    }
  } else if (std::filesystem::exists(configuration)) {
    use_own_estimates(configuration, times);
  }
  if (times.empty()) {
    throw core::InputError(fmt::format("{} tells of no finished task", path.string()),
                           "--trace takes the folder of a dataset, or its trace.json");
  }
  return times;
}

TaskSeconds expected_seconds(const BuildPlan& plan, const std::vector<double>& estimates,
                             const MeasuredTimes& measured) {
  struct Sums {
    double estimate = 0, seconds = 0;
  };
  std::map<std::string, Sums> sums;
  for (const auto& [key, time] : measured) {
    sums[kind_of(key)].estimate += time.estimate;
    sums[kind_of(key)].seconds += time.seconds;
  }
  TaskSeconds out;
  for (const char* kind : {"modes", "samples"}) {
    const Sums& sum = sums[kind];
    out.ratio[kind] = sum.estimate > 0 ? sum.seconds / sum.estimate : 1;
  }
  for (std::size_t t = 0; t < plan.tasks.size(); ++t) {
    const std::string& key = plan.tasks[t].key;
    const auto found = measured.find(key);
    const bool same = found != measured.end() &&
                      std::abs(found->second.estimate - estimates[t]) <= 1e-6 * estimates[t];
    out.measured += same ? 1 : 0;
    out.seconds.push_back(same ? found->second.seconds : estimates[t] * out.ratio.at(kind_of(key)));
  }
  return out;
}

}  // namespace carillon::cli
