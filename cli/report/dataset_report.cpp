#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "cli/build/modes_task.hpp"
#include "cli/report/report.hpp"
#include "cli/sound/scene.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hdf5.hpp"

namespace carillon::cli {

using nlohmann::json;
using nlohmann::ordered_json;

namespace {

/// Tasks that are drawn one by one; of more, the longest.
constexpr std::size_t most_tasks = 4000;

/// A document that may not be there, or not whole: a build may be running.
json read_json(const std::filesystem::path& path, const json& otherwise) {
  if (!std::filesystem::is_regular_file(path)) return otherwise;
  json document = json::parse(core::read_file(path), nullptr, false);
  return document.is_discarded() ? otherwise : document;
}

/// Seconds of every body's modes task.
std::map<std::string, double> modes_seconds(const json& trace) {
  const std::string prefix = "modes/";
  std::map<std::string, double> seconds;
  for (const json& task : trace.value("tasks", json::array())) {
    const std::string name = task.at("task");
    if (name.starts_with(prefix)) seconds[name.substr(prefix.size())] = task.at("seconds");
  }
  return seconds;
}

/// What the body's modes files say: of several sets, the worst.
void add_modes(const std::filesystem::path& path, ordered_json& shape) {
  double complete_to = std::numeric_limits<double>::infinity(), worst = -1, unknowns = 0;
  std::uint64_t modes = 0;
  const core::Hdf5Group file = core::Hdf5Group::open_file(path);
  for (const std::string& name : file.names()) {
    if (!name.starts_with("set-")) continue;
    const core::Hdf5Group set = file.open_group(name);
    const core::Hdf5Group certificate = set.open_group("certificate");
    complete_to = std::min(complete_to, certificate.number_attribute("complete_to_hz"));
    unknowns = std::max(unknowns, certificate.number_attribute("unknowns"));
    modes = std::max(modes, set.extent("eigenvalues").front());
    shape["order"] = static_cast<int>(set.open_group("surface").number_attribute("order"));
    if (!set.has("pitch_errors")) continue;
    for (const double error : set.read<double>("pitch_errors")) worst = std::max(worst, error);
  }
  shape["modes"] = modes;
  shape["complete_to_hz"] = complete_to;
  shape["unknowns"] = unknowns;
  if (worst >= 0) shape["pitch_error_cents"] = worst;
}

ordered_json describe_shapes(const StoredDataset& dataset, const json& trace) {
  const std::map<std::string, double> seconds = modes_seconds(trace);
  const BuildFolders folders{dataset.folder, {}};
  ordered_json shapes = ordered_json::array();
  for (const Shape& shape : dataset.build.plan.shapes) {
    ordered_json entry = {{"id", shape.id},
                          {"family", shape.family},
                          {"split", shape.split_shape},
                          {"variants", shape.variants.size()},
                          {"modes", nullptr},
                          {"complete_to_hz", nullptr},
                          {"pitch_error_cents", nullptr},
                          {"order", nullptr},
                          {"unknowns", nullptr},
                          {"seconds", nullptr}};
    if (const auto found = seconds.find(shape.id); found != seconds.end()) {
      entry["seconds"] = found->second;
    }
    const std::filesystem::path path = folders.modes_file(shape);
    try {
      if (std::filesystem::is_regular_file(path)) add_modes(path, entry);
    } catch (const core::Error& error) {
      entry["failure"] = error.message();
    }
    shapes.push_back(std::move(entry));
  }
  return shapes;
}

/// Every effect as the build decided it, with what the trace counted.
ordered_json describe_effects_run(const StoredDataset& dataset, const json& trace) {
  const json counted = trace.value("effects", json::object());
  ordered_json effects = ordered_json::array();
  for (const json& effect : describe_effects(dataset.build.config.scene)) {
    const json entry = counted.value(effect.at("name").get<std::string>(), json::object());
    effects.push_back({{"name", effect.at("name")},
                       {"enabled", effect.at("enabled")},
                       {"reason", effect.at("reason")},
                       {"calls", entry.value("calls", 0)},
                       {"seconds", entry.value("seconds", 0.0)}});
  }
  return effects;
}

/// The longest tasks in the order they began, and how many are left out.
void add_tasks(const json& trace, ordered_json& report) {
  std::vector<json> tasks = trace.value("tasks", std::vector<json>{});
  const std::size_t all = tasks.size();
  if (all > most_tasks) {
    std::nth_element(
        tasks.begin(), tasks.begin() + most_tasks, tasks.end(),
        [](const json& a, const json& b) { return a.at("seconds") > b.at("seconds"); });
    tasks.resize(most_tasks);
    std::sort(tasks.begin(), tasks.end(),
              [](const json& a, const json& b) { return a.at("start_s") < b.at("start_s"); });
  }
  report["tasks_left_out"] = all - tasks.size();
  report["tasks"] = tasks;
}

}  // namespace

ordered_json dataset_report(const StoredDataset& dataset) {
  const json& said = dataset.description;
  const json trace = read_json(dataset.folder / "trace.json", json::object());
  double bytes = 0;
  for (const json& file : said.at("files")) bytes += file.at("bytes").get<double>();
  ordered_json report = {{"name", said.at("name")},
                         {"folder", dataset.folder.string()},
                         {"about", said.value("about", json::object())},
                         {"samples", said.at("samples")},
                         {"materials", said.at("materials")},
                         {"bytes", bytes},
                         {"configuration", dataset.configuration},
                         {"versions", said.at("versions")},
                         {"shapes", describe_shapes(dataset, trace)},
                         {"stages", trace.value("stages", json::object())},
                         {"effects", describe_effects_run(dataset, trace)},
                         {"ranks", trace.value("ranks", json::array())},
                         {"runs", trace.value("runs", json::array())},
                         {"failures", read_json(dataset.folder / "failures.json", json::array())}};
  double seconds = 0;
  for (const json& task : trace.value("tasks", json::array())) {
    seconds += task.at("seconds").get<double>() * task.at("width").get<double>();
  }
  report["task_seconds"] = seconds;
  add_tasks(trace, report);
  return report;
}

}  // namespace carillon::cli
