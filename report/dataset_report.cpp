#include <algorithm>
#include <functional>
#include <map>

#include "core/files.hpp"
#include "core/json.hpp"
#include "dataset/plan/task_times.hpp"
#include "report/detail/shape_row.hpp"
#include "report/report.hpp"
#include "scene/scene.hpp"

namespace carillon::report {

using nlohmann::json;
using nlohmann::ordered_json;

namespace {

constexpr std::size_t worst_modes = 20;

/// A document that may not be there, or not whole: a build may be running.
json read_if_there(const std::filesystem::path& path, const json& otherwise) {
  json document = core::read_json(path);
  return document.is_null() ? otherwise : document;
}

/// Seconds of every object's modes task.
std::map<std::string, double> modes_seconds(const json& trace) {
  const std::string prefix = "modes/";
  std::map<std::string, double> seconds;
  for (const dataset::plan::TaskRow& row : dataset::plan::task_rows(trace)) {
    if (row.task.starts_with(prefix)) seconds[row.task.substr(prefix.size())] = row.times.seconds;
  }
  return seconds;
}

/// Those of which `seconds` is largest, in the order that they have.
template <class Row>
std::vector<const Row*> longest(const std::vector<Row>& all, std::size_t rows,
                                const std::function<double(const Row&)>& seconds) {
  std::vector<const Row*> chosen;
  for (const Row& row : all) chosen.push_back(&row);
  if (all.size() <= rows) return chosen;
  const auto end = chosen.begin() + static_cast<std::ptrdiff_t>(rows);
  std::nth_element(chosen.begin(), end, chosen.end(),
                   [&](const Row* a, const Row* b) { return seconds(*a) > seconds(*b); });
  chosen.erase(end, chosen.end());
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

void add_shapes(const dataset::stored::StoredDataset& dataset, const json& trace, std::size_t rows,
                ordered_json& report) {
  const std::map<std::string, double> seconds = modes_seconds(trace);
  const auto seconds_of = [&](const dataset::plan::Shape& shape) {
    const auto found = seconds.find(shape.id);
    return found == seconds.end() ? json() : json(found->second);
  };
  std::vector<ModeError> errors;
  report["shapes"] = ordered_json::array();
  for (const dataset::plan::Shape* shape : longest<dataset::plan::Shape>(
           dataset.build.plan.shapes, rows, [&](const dataset::plan::Shape& one) {
             const json known = seconds_of(one);
             return known.is_null() ? 0.0 : known.get<double>();
           })) {
    report["shapes"].push_back(shape_row(dataset, *shape, seconds_of(*shape), errors));
    keep_worst(errors, worst_modes);
  }
  report["pitch_target_cents"] =
      dataset.build.config.pitch_cents > 0 ? json(dataset.build.config.pitch_cents) : json();
  report["worst_modes"] = ordered_json::array();
  for (const ModeError& error : errors) report["worst_modes"].push_back(to_json(error));
}

/// Every effect as the build decided it, with what the trace counted.
ordered_json describe_effects_run(const dataset::stored::StoredDataset& dataset,
                                  const json& trace) {
  const json counted = trace.value("effects", json::object());
  ordered_json effects = ordered_json::array();
  for (const scene::PlannedEffect& effect : scene::plan_effects(dataset.build.config.scene)) {
    const json entry = counted.value(effect.name, json::object());
    effects.push_back({{"name", effect.name},
                       {"enabled", effect.enabled},
                       {"reason", effect.reason},
                       {"calls", entry.value("calls", 0)},
                       {"seconds", entry.value("seconds", 0.0)}});
  }
  return effects;
}

void add_tasks(const json& trace, std::size_t rows, ordered_json& report) {
  const std::vector<dataset::plan::TaskRow> tasks = dataset::plan::task_rows(trace);
  double seconds = 0;
  for (const dataset::plan::TaskRow& row : tasks) seconds += row.times.seconds * row.times.width;
  report["task_seconds"] = seconds;
  report["tasks_run"] = tasks.size();
  std::vector<dataset::plan::TaskRow> chosen;
  for (const dataset::plan::TaskRow* row : longest<dataset::plan::TaskRow>(
           tasks, rows, [](const dataset::plan::TaskRow& one) { return one.times.seconds; })) {
    chosen.push_back(*row);
  }
  report["tasks"] = dataset::plan::to_json(chosen);
}

/// What made it: the last run of its own, or of the sweep whose variant it is; null of older
/// builds.
json last_made(const std::filesystem::path& folder, const json& trace) {
  json runs = trace.value("runs", json::array());
  const std::filesystem::path above = core::tidy_path(folder / "..");
  if (runs.empty() && std::filesystem::is_regular_file(above / "sweep.json")) {
    runs = read_if_there(above / "trace.json", json::object()).value("runs", json::array());
  }
  return runs.empty() ? json() : runs.back().value("made", json());
}

void add_failures(const std::filesystem::path& folder, std::size_t rows, ordered_json& report) {
  const auto add = [&](const char* file, const char* count, const char* name) {
    json list = read_if_there(folder / file, json::array());
    report[count] = list.size();
    if (list.size() > rows)
      list.erase(list.begin() + static_cast<std::ptrdiff_t>(rows), list.end());
    report[name] = list;
  };
  add("failures.json", "failed", "failures");
  add("warnings.json", "warned", "warnings");
}

}  // namespace

ordered_json dataset_report(const dataset::stored::StoredDataset& dataset, std::size_t rows) {
  const json& said = dataset.description;
  const json trace = read_if_there(dataset.folder / "trace.json", json::object());
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
                         {"objects", dataset.build.plan.shapes.size()},
                         {"stages", trace.value("stages", json::object())},
                         {"effects", describe_effects_run(dataset, trace)},
                         {"ranks", trace.value("ranks", json::array())},
                         {"runs", trace.value("runs", json::array())},
                         {"made", last_made(dataset.folder, trace)},
                         {"missed_pitch_targets", trace.value("missed_pitch_targets", json())}};
  add_shapes(dataset, trace, rows, report);
  add_tasks(trace, rows, report);
  add_failures(dataset.folder, rows, report);
  return report;
}

}  // namespace carillon::report
