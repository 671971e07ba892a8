#include "cli/build/progress_so_far.hpp"

#include <fmt/format.h>

#include "cli/build/dataset.hpp"
#include "cli/build/failures.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hash.hpp"

namespace carillon::cli {

using nlohmann::json;

std::map<std::string, json> finished_tasks(const std::vector<json>& journal) {
  std::map<std::string, json> finished;
  for (const json& entry : journal) {
    if (entry.contains("task")) finished[entry.at("task")] = entry;  // else not an outcome
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

Results write_results(const LoadedBuild& build, const BuildFolders& folders,
                      const std::map<std::string, json>& finished, JoinedFiles& joined) {
  Results results;
  std::vector<std::size_t> done;
  json files = json::array(), pitch_targets = json::object();
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
    }
  }
  const json failures = describe_failures(build, folders.output.string(), finished);
  write_index(build.config, build.plan, done, folders, joined);
  write_descriptions(build.config, build.plan, results.samples, pitch_targets, files, failures,
                     folders);
  results.failed = failures.size();
  return results;
}

Results write_results(const LoadedBuild& build, const BuildFolders& folders,
                      const std::map<std::string, json>& finished) {
  JoinedFiles joined(folders.output);
  return write_results(build, folders, finished, joined);
}

}  // namespace carillon::cli
