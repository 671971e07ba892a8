#include "dataset/run/progress_so_far.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hash.hpp"
#include "dataset/run/croissant.hpp"
#include "dataset/run/dataset.hpp"
#include "dataset/run/detail/failures.hpp"

namespace carillon::dataset::run {

using nlohmann::json;

std::map<std::string, json> finished_tasks(const std::vector<json>& journal) {
  std::map<std::string, json> finished;
  for (const json& entry : journal) {
    if (!entry.contains("task")) continue;  // not an outcome
    if (entry.value("lasting", true)) {
      finished[entry.at("task")] = entry;
    } else {
      finished.erase(entry.at("task").get<std::string>());
    }
  }
  return finished;
}

std::vector<ListedFile> describe_files(const std::vector<std::string>& written,
                                       const std::filesystem::path& output) {
  std::vector<ListedFile> files;
  for (const std::string& path : written) {
    files.push_back(
        {path, core::sha256_file(output / path), std::filesystem::file_size(output / path)});
  }
  return files;
}

Gathered gather(const plan::BuildPlan& plan, const std::map<std::string, json>& finished) {
  Gathered all;
  for (std::size_t t = 0; t < plan.tasks.size(); ++t) {
    const plan::BuildTask& task = plan.tasks[t];
    const auto found = finished.find(task.key);
    if (found == finished.end() || !found->second.at("ok").get<bool>()) continue;
    const json& entry = found->second;
    if (task.kind == plan::TaskKind::samples) {
      all.done.push_back(t);
      all.samples += task.count;
    }
    if (entry.contains("pitch_target")) {
      all.pitch_targets[plan.shapes[task.shape].id] = entry.at("pitch_target");
    }
    for (const json& warning : entry.value("warnings", json::array()))
      all.warnings.push_back({{"task", task.key}, {"message", warning}});
    for (const json& file : entry.at("files")) all.files.push_back(file.get<ListedFile>());
  }
  return all;
}

Results write_results(const LoadedBuild& build, const samples::BuildFolders& folders,
                      const std::map<std::string, json>& finished, JoinedFiles& joined) {
  const Gathered all = gather(build.plan, finished);
  const json failures = describe_failures(build, folders.output.string(), finished);
  const json dataset =
      describe_dataset(build.config, build.plan, all.samples, all.pitch_targets, all.files);
  write_index(build.config, build.plan, all.done, folders, folders.output / "index.h5", joined);
  core::write_text_durably(folders.output / "dataset.json", dataset.dump(2) + "\n");
  core::write_text_durably(folders.output / "croissant.json",
                           dataset_croissant(folders.output, dataset).dump(2) + "\n");
  core::write_text_durably(folders.output / "failures.json", failures.dump(2) + "\n");
  core::write_text_durably(folders.output / "warnings.json", all.warnings.dump(2) + "\n");
  return {all.samples, failures.size(), all.warnings.size(), dataset.at("missed_pitch_targets")};
}

Results write_results(const LoadedBuild& build, const samples::BuildFolders& folders,
                      const std::map<std::string, json>& finished) {
  JoinedFiles joined(folders.output);
  return write_results(build, folders, finished, joined);
}

}  // namespace carillon::dataset::run
