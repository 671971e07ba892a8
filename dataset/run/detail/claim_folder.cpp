#include "dataset/run/detail/claim_folder.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <set>
#include <sstream>

#include "core/error.hpp"
#include "core/files.hpp"
#include "dataset/run/detail/task_inputs.hpp"
#include "solvers/mesh/shape_source.hpp"

namespace carillon::dataset::run {

using nlohmann::json;

namespace {

constexpr const char* remedy = "choose another folder with --output, or remove this one";

std::multiset<std::string> lines_of(const std::string& text) {
  std::multiset<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with("# inputs")) lines.insert(line);
  }
  return lines;
}

std::string difference(const std::string& old, const std::string& now) {
  const auto before = lines_of(old), after = lines_of(now);
  std::string text;
  for (const std::string& line : before) {
    if (before.count(line) > after.count(line)) text += "\n  - " + line;
  }
  for (const std::string& line : after) {
    if (after.count(line) > before.count(line)) text += "\n  + " + line;
  }
  return text;
}

bool same_object(const plan::Shape& a, const plan::Shape& b) {
  return a.family == b.family && a.path == b.path && a.sha256 == b.sha256 &&
         solvers::mesh::to_json(a.request) == solvers::mesh::to_json(b.request);
}

/// What the new plan does not hold as the old one did, or nothing when it only adds.
std::string lost(const plan::BuildPlan& old, const plan::BuildPlan& now) {
  std::map<std::string, const plan::Shape*> shapes;
  for (const plan::Shape& shape : now.shapes) shapes[shape.id] = &shape;
  for (const plan::Shape& shape : old.shapes) {
    const auto found = shapes.find(shape.id);
    if (found == shapes.end()) return fmt::format("the object {} would go", shape.id);
    if (!same_object(shape, *found->second))
      return fmt::format("{} would be another object", shape.id);
    if (shape.split_shape != found->second->split_shape ||
        shape.identity != found->second->identity) {
      return fmt::format("{} would move to another part of the split", shape.id);
    }
  }
  std::set<std::string> keys;
  for (const plan::Sample& sample : now.samples) keys.insert(sample.key);
  for (const plan::Sample& sample : old.samples) {
    if (!keys.contains(sample.key)) return fmt::format("the sample {} would go", sample.key);
  }
  return {};
}

/// A task that was done from other files than those that the old configuration finds now.
std::string done_from_others(const configuration::BuildConfig& config, plan::BuildPlan plan,
                             const std::map<std::string, json>& entries) {
  // Simulations were cast with the objects that there were then; files may match that came since.
  for (plan::BuildTask& task : plan.tasks) {
    std::erase_if(task.cast, [&](std::size_t shape) {
      return !entries.contains("modes/" + plan.shapes[shape].id);
    });
  }
  const Standing standing = sort_entries(config, plan, entries);
  for (const auto& [task, entry] : entries) {
    const bool good = standing.finished.contains(task) || standing.grown.contains(task);
    if (entry.value("ok", false) && !good) return task;
  }
  return {};
}

}  // namespace

void claim_folder(const LoadedBuild& build, const std::filesystem::path& output,
                  const std::map<std::string, json>& entries) {
  const std::filesystem::path path = output / "configuration.yaml";
  const std::string text =
      build.config.resolved +
      fmt::format("# inputs: {}\n", plan::fingerprint(build.config, build.plan));
  if (!std::filesystem::exists(path)) {
    if (!entries.empty()) {
      spdlog::warn("{} is missing: written again; tasks of another configuration run again",
                   path.string());
    }
    core::write_text_durably(path, text);
    return;
  }
  const std::string old_text = core::read_file(path);
  if (old_text == text) return;
  const std::string lines = difference(old_text, text);
  const auto refuse = [&](const std::string& reason) {
    throw core::ConfigError(
        fmt::format("{} was built with another configuration{}:{}", output.string(), reason, lines),
        remedy);
  };
  configuration::BuildConfig old;
  plan::BuildPlan old_plan;
  try {
    // Paths in it are meant from where the configuration lies.
    old = configuration::read_build_config(old_text, build.path, {});
    old_plan = plan::make_plan(old);
  } catch (const std::exception& error) {
    if (lines.empty()) throw;
    refuse("");
  }
  if (without_growth(old) != without_growth(build.config)) refuse("");
  const std::string gone = lost(old_plan, build.plan);
  if (!gone.empty() && !lines.empty()) refuse(" (" + gone + ")");
  const std::string task = done_from_others(old, old_plan, entries);
  if (!gone.empty() || !task.empty()) {
    throw core::ConfigError(
        fmt::format("{} was built from other files: a mesh, the materials, the strikes or a "
                    "profile that the configuration names has changed ({})",
                    output.string(), gone.empty() ? task + " was made from another" : gone),
        remedy);
  }
  if (build.plan.samples.size() > old_plan.samples.size()) {
    spdlog::info("{}: adding {} samples to {}", output.string(),
                 build.plan.samples.size() - old_plan.samples.size(), old_plan.samples.size());
  }
  core::write_text_durably(path, text);
}

}  // namespace carillon::dataset::run
