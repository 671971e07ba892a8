#include "dataset/run/detail/failures.hpp"

#include <fmt/format.h>

namespace carillon::dataset::run {

using nlohmann::json;

namespace {

/// As one word of a shell.
std::string quoted(const std::string& word) {
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// Key of the sample that a failure is met with: the one that failed, or any of the same object.
std::string sample_of(const LoadedBuild& build, const plan::BuildTask& task,
                      const std::string& item) {
  if (!item.empty()) return item;
  if (task.kind == plan::TaskKind::samples) return build.plan.samples[task.first].key;
  for (const plan::Sample& sample : build.plan.samples) {
    if (sample.shape == task.shape) return sample.key;
  }
  return "";  // an object that no given strike speaks of
}

/// The command that meets a failed task's reason again: one sample of the same object, or, where
/// files could not be written, the build itself.
std::string reproduce(const LoadedBuild& build, const std::string& output,
                      const plan::BuildTask& task, const json& entry) {
  const std::string sample = sample_of(build, task, entry.value("item", ""));
  const bool again = entry.value("stage", "") == "write" || sample.empty();
  const int ranks = entry.contains("times") ? entry.at("times").at("width").get<int>() : 1;
  std::string command = ranks > 1 ? fmt::format("mpirun -n {} ", ranks) : "";
  command += again ? "carillon build " : "carillon preview ";
  command += quoted(build.path);
  for (const std::string& assignment : build.overrides) command += " --set " + quoted(assignment);
  if (again) return command + " --output " + quoted(output) + " --retry-failed";
  return command + " --sample " + quoted(sample);
}

/// Samples tasks that are left out because the modes of their object failed.
json skipped_with(const LoadedBuild& build, const plan::BuildTask& failed,
                  const std::map<std::string, json>& finished) {
  json skipped = json::array();
  if (failed.kind != plan::TaskKind::modes) return skipped;
  for (const plan::BuildTask& task : build.plan.tasks) {
    const bool waits = task.kind == plan::TaskKind::samples && task.shape == failed.shape;
    if (waits && !finished.contains(task.key)) skipped.push_back(task.key);
  }
  return skipped;
}

}  // namespace

json describe_failures(const LoadedBuild& build, const std::string& output,
                       const std::map<std::string, json>& finished) {
  json failures = json::array();
  for (const plan::BuildTask& task : build.plan.tasks) {
    const auto found = finished.find(task.key);
    if (found == finished.end() || found->second.at("ok").get<bool>()) continue;
    const json& entry = found->second;
    json failure = {{"task", task.key},
                    {"kind", entry.value("kind", "Error")},
                    {"message", entry.value("message", "")},
                    {"hint", entry.value("hint", "")},
                    {"skipped", skipped_with(build, task, finished)},
                    {"reproduce", reproduce(build, output, task, entry)}};
    if (entry.contains("stage")) failure["stage"] = entry.at("stage");
    if (entry.contains("item")) failure["sample"] = entry.at("item");
    failures.push_back(failure);
  }
  return failures;
}

}  // namespace carillon::dataset::run
