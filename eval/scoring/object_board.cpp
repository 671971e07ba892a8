#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/json.hpp"
#include "eval/scoring/object_entry.hpp"
#include "eval/validation/estimator_errors.hpp"

namespace carillon::eval::scoring {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

/// A measure of each shape, NaN where it has none: the median over its materials and sizes, whose
/// modes are the same but for a factor.
std::vector<double> by_shape(const ObjectEntry& entry, const ObjectMeasure& measure) {
  std::map<std::string, std::vector<double>> values;
  for (std::size_t o = 0; o < entry.objects.size(); ++o) {
    const std::string& name = entry.objects[o];
    // Every shape has its place, so that entries can be compared.
    std::vector<double>& of_shape = values[name.substr(0, name.find('/'))];
    if (std::isfinite(measure.values[o])) of_shape.push_back(measure.values[o]);
  }
  std::vector<double> medians;
  for (auto& [shape, all] : values) medians.push_back(core::median(std::move(all)));
  return medians;
}

Measure summed_up(const ObjectEntry& entry, const ObjectMeasure& measure) {
  core::RandomStream random(0, core::stable_hash(entry.name), "score.objects");
  const validation::ErrorSummary summary =
      validation::summarise_errors(by_shape(entry, measure), random);
  return {measure.name, measure.unit, {summary.median, summary.median95}};
}

ObjectEntry kept_objects(const fs::path& folder) {
  const nlohmann::json about = core::read_json(folder / "entry.json");
  ObjectEntry entry;
  try {
    entry.name = about.at("entry");
    entry.objects = about.at("objects").get<std::vector<std::string>>();
    entry.notes = about.at("notes").get<std::vector<std::string>>();
    for (const nlohmann::json& measure : about.at("measures")) {
      ObjectMeasure& own = entry.measures.emplace_back();
      own.name = measure.at("name");
      own.unit = measure.at("unit");
      for (const nlohmann::json& value : measure.at("values")) {
        own.values.push_back(core::number_or_nan(value));
      }
      if (own.values.size() != entry.objects.size()) {
        throw core::FileError(fmt::format("{} is damaged", (folder / "entry.json").string()));
      }
    }
  } catch (const nlohmann::json::exception& error) {
    throw core::FileError(
        fmt::format("{} is damaged: {}", (folder / "entry.json").string(), error.what()));
  }
  return entry;
}

void compare(std::vector<BoardRow>& rows, const std::map<std::string, ObjectEntry>& entries) {
  if (rows.size() < 2) return;
  std::vector<double> probabilities;
  const auto first_measure = [&](const BoardRow& row) {
    const ObjectEntry& entry = entries.at(row.entry);
    return by_shape(entry, entry.measures.front());
  };
  const std::vector<double> first = first_measure(rows.front());
  for (std::size_t r = 1; r < rows.size(); ++r) {
    const validation::EstimatorComparison found =
        validation::compare_errors(first_measure(rows[r]), first);
    rows[r].difference = Estimate{found.median_difference, {core::nan, core::nan}};
    probabilities.push_back(found.signed_rank.p);
  }
  const std::vector<double> raised = statistics::holm(probabilities);
  for (std::size_t r = 1; r < rows.size(); ++r) rows[r].is_told_apart = raised[r - 1] < 0.05;
}

}  // namespace

void keep_entry(const ObjectEntry& entry, const fs::path& folder) {
  ordered_json measures = ordered_json::array();
  for (const ObjectMeasure& measure : entry.measures) {
    ordered_json values = ordered_json::array();
    for (const double value : measure.values) values.emplace_back(core::number_or_null(value));
    measures.push_back({{"name", measure.name}, {"unit", measure.unit}, {"values", values}});
  }
  const ordered_json about = {{"entry", entry.name},
                              {"objects", entry.objects},
                              {"measures", measures},
                              {"notes", entry.notes}};
  core::write_text_durably(folder / "entry.json", about.dump(1) + "\n");
}

Leaderboard object_board(const fs::path& evaluation, ObjectTask task, const TrueObjects& truth) {
  Leaderboard board{fs::path(truth.dataset).filename().string(),
                    std::string(name_of(task)),
                    fmt::format("{} objects that are held out (`split_shape`). Medians over their "
                                "shapes with 95 % intervals; told apart by signed ranks of the "
                                "same shapes, among all rows.",
                                truth.objects.size()),
                    false,
                    {},
                    {}};
  std::vector<std::string> names;
  for (const TrueObject& object : truth.objects) {
    if (!object.eigenvalues.empty()) names.push_back(object.name);
  }
  std::map<std::string, ObjectEntry> entries;
  for (const fs::path& place : kept_entries(evaluation, board.task)) {
    try {
      ObjectEntry entry = kept_objects(place);
      if (entry.objects != names) {
        throw core::InputError(
            fmt::format("{} answered for another state of the dataset", place.string()));
      }
      BoardRow& row = board.rows.emplace_back();
      row.entry = entry.name;
      for (const ObjectMeasure& measure : entry.measures) {
        const bool is_told = std::any_of(measure.values.begin(), measure.values.end(),
                                         [](double value) { return !std::isnan(value); });
        if (is_told) row.measures.push_back(summed_up(entry, measure));
      }
      entries.emplace(entry.name, std::move(entry));
    } catch (const core::Error& error) {
      board.notes.push_back(fmt::format("left out: {}", error.message()));
    }
  }
  sort(board);
  compare(board.rows, entries);
  return board;
}

}  // namespace carillon::eval::scoring
