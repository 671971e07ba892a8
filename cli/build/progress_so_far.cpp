#include "cli/build/progress_so_far.hpp"

#include <fmt/format.h>

#include <set>
#include <sstream>

#include "cli/build/dataset.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hash.hpp"

namespace carillon::cli {

using nlohmann::json;

std::map<std::string, json> finished_tasks(const mpi::Journal& journal,
                                           const std::filesystem::path& output) {
  std::map<std::string, json> finished;
  for (const json& entry : journal.entries()) finished[entry.at("task")] = entry;
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

}  // namespace

void claim_folder(const BuildConfig& config, const std::filesystem::path& output) {
  const std::filesystem::path path = output / "configuration.yaml";
  if (!std::filesystem::exists(path)) {
    core::write_text_durably(path, config.resolved);
    return;
  }
  const std::string old = core::read_file(path);
  if (old == config.resolved) return;
  const auto before = lines_of(old), now = lines_of(config.resolved);
  std::string difference;
  for (const std::string& line : before) {
    if (!now.contains(line)) difference += "\n  - " + line;
  }
  for (const std::string& line : now) {
    if (!before.contains(line)) difference += "\n  + " + line;
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

namespace {

/// The command that meets a failed task's reason again.
std::string reproduce(const LoadedBuild& build, const BuildTask& task) {
  const Shape& shape = build.plan.shapes[task.shape];
  const solvers::MeshRequest& request = shape.request;
  std::string mesh = shape.path;
  if (mesh.empty()) {
    std::vector<std::string> values;
    for (const auto& [name, value] : request.shape.parameters) {
      values.push_back(fmt::format("{}={}", name, value));
    }
    mesh = fmt::format("{}:{}", shape.family, fmt::join(values, ","));
  }
  std::string command = fmt::format("carillon modes {} --material {} --order {}", mesh,
                                    shape.variants.front().material, request.options.order);
  if (request.file.length > 0) command += fmt::format(" --length {}", request.file.length);
  if (request.file.thickness > 0) command += fmt::format(" --thickness {}", request.file.thickness);
  if (request.file.any_size) command += " --any-size";
  return command;
}

}  // namespace

std::size_t write_results(const LoadedBuild& build, const BuildFolders& folders,
                          const std::map<std::string, json>& finished) {
  std::vector<std::size_t> done;
  json files = json::array(), failures = json::array();
  for (std::size_t t = 0; t < build.plan.tasks.size(); ++t) {
    const BuildTask& task = build.plan.tasks[t];
    const auto found = finished.find(task.key);
    if (found == finished.end()) continue;
    const json& entry = found->second;
    if (entry.at("ok").get<bool>()) {
      if (task.kind == TaskKind::samples) done.push_back(t);
      for (const json& file : entry.at("files")) files.push_back(file);
    } else {
      failures.push_back({{"task", task.key},
                          {"kind", entry.value("kind", "Error")},
                          {"message", entry.value("message", "")},
                          {"hint", entry.value("hint", "")},
                          {"reproduce", reproduce(build, task)}});
    }
  }
  write_index(build.plan, done, folders);
  write_descriptions(build.config, build.plan, files, failures, folders);
  return failures.size();
}

}  // namespace carillon::cli
