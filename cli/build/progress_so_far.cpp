#include "cli/build/progress_so_far.hpp"

#include <fmt/format.h>

#include "cli/build/dataset.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hash.hpp"

namespace carillon::cli {

using nlohmann::json;

std::map<std::string, json> finished_tasks(const mpi::Journal& journal) {
  std::map<std::string, json> finished;
  for (const json& entry : journal.entries()) {
    if (entry.contains("task") && entry.contains("ok")) finished[entry.at("task")] = entry;
  }
  return finished;
}

json describe_files(const std::vector<std::string>& written, const std::filesystem::path& output) {
  json files = json::array();
  for (const std::string& path : written) {
    files.push_back({{"path", path},
                     {"sha256", core::sha256_file(output / path)},
                     {"bytes", std::filesystem::file_size(output / path)}});
  }
  return files;
}

namespace {

/// As one word of a shell.
std::string quoted(const std::string& word) {
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// The command that meets a failed task's reason again: a sample of the same body.
std::string reproduce(const LoadedBuild& build, const BuildTask& task) {
  std::string command = "carillon preview " + quoted(build.path);
  for (const std::string& assignment : build.overrides) command += " --set " + quoted(assignment);
  for (const Sample& sample : build.plan.samples) {
    if (sample.shape == task.shape) return command + " --sample " + quoted(sample.key);
  }
  return command;
}

/// Samples tasks that are left out because the modes of their body failed.
json skipped_with(const LoadedBuild& build, const BuildTask& failed,
                  const std::map<std::string, json>& finished) {
  json skipped = json::array();
  if (failed.kind != TaskKind::modes) return skipped;
  for (const BuildTask& task : build.plan.tasks) {
    const bool waits = task.kind == TaskKind::samples && task.shape == failed.shape;
    if (waits && !finished.contains(task.key)) skipped.push_back(task.key);
  }
  return skipped;
}

}  // namespace

Results write_results(const LoadedBuild& build, const BuildFolders& folders,
                      const std::map<std::string, json>& finished) {
  Results results;
  std::vector<std::size_t> done;
  json files = json::array(), failures = json::array(), pitch_targets = json::object();
  for (std::size_t t = 0; t < build.plan.tasks.size(); ++t) {
    const BuildTask& task = build.plan.tasks[t];
    const auto found = finished.find(task.key);
    if (found == finished.end()) continue;
    const json& entry = found->second;
    if (entry.at("ok").get<bool>()) {
      if (task.kind == TaskKind::samples) {
        done.push_back(t);
        results.samples += task.count;
      }
      if (entry.contains("pitch_target")) {
        const std::string& shape = build.plan.shapes[task.shape].id;
        pitch_targets[shape] = entry.at("pitch_target");
        if (!entry.at("pitch_target").at("met").get<bool>()) results.missed.push_back(shape);
      }
      for (const json& file : entry.at("files")) files.push_back(file);
    } else {
      failures.push_back({{"task", task.key},
                          {"kind", entry.value("kind", "Error")},
                          {"message", entry.value("message", "")},
                          {"hint", entry.value("hint", "")},
                          {"skipped", skipped_with(build, task, finished)},
                          {"reproduce", reproduce(build, task)}});
    }
  }
  write_index(build.config, build.plan, done, folders);
  write_descriptions(build.config, build.plan, results.samples, pitch_targets, files, failures,
                     folders);
  results.failed = failures.size();
  return results;
}

}  // namespace carillon::cli
