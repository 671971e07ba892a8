#include "cli/build/progress_so_far.hpp"

#include <fmt/format.h>

#include <set>
#include <sstream>

#include "cli/build/dataset.hpp"
#include "cli/build/failures.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hash.hpp"

namespace carillon::cli {

using nlohmann::json;

std::map<std::string, json> finished_tasks(const mpi::Journal& journal,
                                           const std::filesystem::path& output) {
  std::map<std::string, json> finished;
  for (const json& entry : journal.entries()) {
    if (entry.contains("task")) finished[entry.at("task")] = entry;  // else not an outcome
  }
  std::erase_if(finished, [&](const auto& item) {
    for (const json& file : item.second.value("files", json::array())) {
      std::error_code error;
      const auto bytes =
          std::filesystem::file_size(output / file.at("path").get<std::string>(), error);
      if (error || bytes != file.at("bytes").get<std::uintmax_t>()) return true;
    }
    return false;
  });
  return finished;
}

namespace {

std::multiset<std::string> lines_of(const std::string& text) {
  std::multiset<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.insert(line);
  return lines;
}

/// A configuration without its block `limits:`, which decides what fails and no value.
std::string without_limits(const std::string& text) {
  std::string kept;
  std::istringstream in(text);
  bool inside = false;
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with(' ')) inside = line.starts_with("limits:");
    if (!inside) kept += line + "\n";
  }
  return kept;
}

}  // namespace

void claim_folder(const LoadedBuild& build, const std::filesystem::path& output) {
  const std::filesystem::path path = output / "configuration.yaml";
  const std::string text =
      build.config.resolved + fmt::format("# inputs: {}\n", fingerprint(build.config, build.plan));
  if (!std::filesystem::exists(path)) {
    core::write_text_durably(path, text);
    return;
  }
  const std::string old = core::read_file(path);
  if (old == text) return;
  if (without_limits(old) == without_limits(text)) {
    core::write_text_durably(path, text);
    return;
  }
  if (old.starts_with(build.config.resolved)) {
    throw core::ConfigError(
        fmt::format("{} was built from other files: a mesh, the materials, the strikes or a "
                    "profile that the configuration names has changed",
                    output.string()),
        "choose another folder with --output, or remove this one");
  }
  const auto before = lines_of(old), now = lines_of(text);
  std::string difference;
  for (const std::string& line : before) {
    if (!now.contains(line) && !line.starts_with("# inputs")) difference += "\n  - " + line;
  }
  for (const std::string& line : now) {
    if (!before.contains(line) && !line.starts_with("# inputs")) difference += "\n  + " + line;
  }
  throw core::ConfigError(
      fmt::format("{} was built with another configuration:{}", output.string(), difference),
      "choose another folder with --output, or remove this one");
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
                      const std::map<std::string, json>& finished) {
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
  write_index(build.config, build.plan, done, folders);
  write_descriptions(build.config, build.plan, results.samples, pitch_targets, files, failures,
                     folders);
  results.failed = failures.size();
  return results;
}

}  // namespace carillon::cli
