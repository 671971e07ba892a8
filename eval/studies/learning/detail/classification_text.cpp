#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/csv.hpp"
#include "core/json.hpp"
#include "core/progress.hpp"
#include "eval/scoring/seed_answers.hpp"
#include "eval/scoring/tables.hpp"
#include "eval/studies/learning/detail/classification.hpp"

namespace carillon::eval::studies {

using nlohmann::ordered_json;

namespace {

const char* held_out_groups(const learning::TaskSpec& task) {
  return task.split == "split_shape" ? "objects" : "strikes";
}

/// Without what is not a mean over seeds.
ordered_json recognition_json(const recognition::RecognitionTrial& trial) {
  ordered_json found = to_json(trial);
  for (const char* name : {"temperature", "uncalibrated_error"}) found.erase(name);
  for (ordered_json& unknown : found["unknown"]) unknown.erase("sounds");
  return found;
}

ordered_json to_json(const ClassificationRow& row) {
  ordered_json recalls = ordered_json::array();
  for (const double recall : classification::recalls(row.confusion)) {
    recalls.emplace_back(core::number_or_null(recall));
  }
  ordered_json found = {
      {"dataset", row.dataset},
      {"task", row.task},
      {"method", row.method},
      {"modalities", row.modalities},
      {"seeds", row.seeds},
      {"samples", row.samples},
      {"groups", row.groups},
      {"classes", row.classes},
      {"accuracy", scoring::accuracy_json(row.accuracy)},
      {"balanced_accuracy", scoring::accuracy_json(row.balanced_accuracy)},
      {"recalls", recalls},
      {"confusion", scoring::counts_json(row.confusion)},
      {"validation_accuracy", core::number_or_null(row.validation_accuracy)},
      {"parameters", row.parameters},
      {"training_s", core::number_or_null(row.training_s)},
      {"recognition", row.recognition ? recognition_json(*row.recognition) : ordered_json()},
      {"published", nullptr},
      {"chosen", row.chosen},
      {"difference", to_json(row.difference)}};
  if (row.published) {
    found["published"] = {{"set", row.published->set}, {"accuracy", row.published->accuracy}};
  }
  if (row.difference) found["difference"]["from"] = row.difference_from;
  return found;
}

using Rows = std::vector<const ClassificationRow*>;

std::string accuracy_table(const Rows& rows) {
  const bool published = std::any_of(rows.begin(), rows.end(), [](const ClassificationRow* row) {
    return row->published.has_value();
  });
  std::vector<std::vector<std::string>> cells = {{"method", "modalities", "seeds", "accuracy",
                                                  "less the chosen one's", "balanced",
                                                  "between seeds", "numbers", "time"}};
  if (published) cells.front().emplace_back("paper");
  for (const ClassificationRow* row : rows) {
    cells.push_back({row->method, row->modalities, fmt::format("{}", row->seeds.size()),
                     scoring::with_interval(row->accuracy),
                     row->chosen ? "chosen" : scoring::with_interval(row->difference),
                     scoring::with_interval(row->balanced_accuracy),
                     row->accuracy ? scoring::percent(row->accuracy->deviation) : "-",
                     fmt::format("{}", row->parameters), core::human_duration(row->training_s)});
    if (published)
      cells.back().push_back(row->published ? scoring::percent(row->published->accuracy) : "-");
  }
  return scoring::markdown(cells);
}

/// Of those that only hear: how right their confidences are, and what they make of other sounds.
std::string recognition_table(const Rows& rows) {
  std::vector<std::vector<std::string>> cells = {
      {"method", "calibration error", "accepted", "of none of the classes",
       "area under the characteristic", "accepted of these"}};
  for (const ClassificationRow* row : rows) {
    if (!row->recognition) continue;
    const recognition::RecognitionTrial& found = *row->recognition;
    std::string method = row->method, accepted = scoring::percent(found.accepted),
                error = fmt::format("{} ({} by chance)", scoring::percent(found.calibration_error),
                                    scoring::percent(found.calibration_by_chance));
    for (const auto& [name, unknown] : found.unknown) {
      cells.push_back({method, error, accepted, name,
                       scoring::with_interval(scoring::Estimate{unknown.auroc, unknown.auroc95}),
                       scoring::percent(unknown.accepted)});
      method = error = accepted = "";
    }
  }
  return cells.size() == 1 ? ""
                           : "\nHow sure they are, and of what they are not (percent):\n\n" +
                                 scoring::markdown(cells);
}

/// Recall of each class, and which other it is taken for most often.
std::string recall_table(const ClassificationRow& row) {
  std::vector<std::vector<std::string>> cells = {
      {"class", "answers", "recall", "most often taken for"}};
  const std::vector<double> recalls = classification::recalls(row.confusion);
  for (std::size_t c = 0; c < row.classes.size(); ++c) {
    std::size_t all = 0, other = c;
    for (std::size_t k = 0; k < row.classes.size(); ++k) {
      const std::size_t count = row.confusion.at(c, k);
      all += count;
      if (k != c && count > 0 && (other == c || count > row.confusion.at(c, other))) other = k;
    }
    cells.push_back({row.classes[c], fmt::format("{}", all), scoring::percent(recalls[c]),
                     other == c
                         ? "-"
                         : fmt::format("{} ({})", row.classes[other], row.confusion.at(c, other))});
  }
  return scoring::markdown(cells);
}

/// Of published sets that stand beside: what is not the same.
constexpr const char* differences =
    "\nThe papers' column is of Sterling 2019, Tables 6.1 to 6.5, on other sounds: their objects, "
    "materials' parameters and splits are not public, their layer sizes are not given, and "
    "their one run has no interval. VGG16 on pictures (Table 6.1) is left out: its pictures "
    "are not theirs or ours to give. Numbers may be compared in kind, not to the percent.\n";

}  // namespace

ordered_json to_json(const Classification& found) {
  ordered_json document = {{"name", found.name},
                           {"tasks", ordered_json::array()},
                           {"datasets", ordered_json::array()},
                           {"rows", ordered_json::array()}};
  for (const learning::TaskSpec& task : found.tasks) {
    document["tasks"].push_back({{"name", task.name},
                                 {"column", task.column},
                                 {"split", task.split},
                                 {"groups_are", held_out_groups(task)}});
  }
  for (const Classification::Dataset& dataset : found.datasets) {
    document["datasets"].push_back({{"name", dataset.name}, {"folder", dataset.folder}});
  }
  for (const ClassificationRow& row : found.rows) document["rows"].push_back(to_json(row));
  return document;
}

std::string to_text(const Classification& found) {
  std::string text = fmt::format("# {}: classification\n", found.name);
  bool published = false;
  for (const learning::TaskSpec& task : found.tasks) {
    for (const Classification::Dataset& dataset : found.datasets) {
      Rows rows;
      for (const ClassificationRow& row : found.rows) {
        if (row.task == task.name && row.dataset == dataset.name) rows.push_back(&row);
        published = published || row.published;
      }
      if (rows.empty()) continue;
      const ClassificationRow& first = *rows.front();
      text += fmt::format(
          "\n## {} of {}\n\n"
          "{} classes, {} samples of {} {} held out (`{}`); percent, with 95 % intervals over {} "
          "and, of several, seeds.\n\n",
          task.name, dataset.name, first.classes.size(), first.samples, first.groups,
          held_out_groups(task), task.split, held_out_groups(task));
      text += accuracy_table(rows);
      text += recognition_table(rows);
      const ClassificationRow& best = **std::find_if(
          rows.begin(), rows.end(), [](const ClassificationRow* row) { return row->chosen; });
      text += fmt::format("\n{}, the best on the validation samples, by class:\n\n", best.method);
      text += recall_table(best);
    }
  }
  return published ? text + differences : text;
}

std::string to_csv(const Classification& found) {
  std::string csv = core::csv_line({"dataset",
                                    "task",
                                    "method",
                                    "modalities",
                                    "seeds",
                                    "samples",
                                    "groups",
                                    "classes",
                                    "accuracy",
                                    "accuracy_low",
                                    "accuracy_high",
                                    "balanced_accuracy",
                                    "balanced_low",
                                    "balanced_high",
                                    "difference",
                                    "difference_low",
                                    "difference_high",
                                    "seeds_deviation",
                                    "validation_accuracy",
                                    "parameters",
                                    "training_s",
                                    "published_set",
                                    "published_accuracy"});
  const auto number = [](double value) { return core::csv_value(core::number_or_null(value)); };
  for (const ClassificationRow& row : found.rows) {
    std::vector<std::string> cells = {row.dataset, row.task, row.method, row.modalities};
    for (const std::size_t count :
         {row.seeds.size(), row.samples, row.groups, row.classes.size()}) {
      cells.push_back(fmt::format("{}", count));
    }
    for (const auto& estimate : {row.accuracy, row.balanced_accuracy, row.difference}) {
      const scoring::Estimate known =
          estimate.value_or(scoring::Estimate{core::nan, {core::nan, core::nan}});
      for (const double value : {known.mean, known.interval95.low, known.interval95.high}) {
        cells.push_back(number(value));
      }
    }
    cells.push_back(row.accuracy ? number(row.accuracy->deviation) : "");
    cells.push_back(number(row.validation_accuracy));
    cells.push_back(fmt::format("{}", row.parameters));
    cells.push_back(number(row.training_s));
    cells.push_back(row.published ? row.published->set : "");
    cells.push_back(row.published ? number(row.published->accuracy) : "");
    csv += core::csv_line(cells);
  }
  return csv;
}

}  // namespace carillon::eval::studies
