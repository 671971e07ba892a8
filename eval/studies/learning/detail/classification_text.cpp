#include "eval/studies/learning/detail/classification_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "core/csv.hpp"
#include "core/progress.hpp"
#include "eval/studies/learning/detail/tables.hpp"

namespace carillon::eval::studies {

using nlohmann::ordered_json;

namespace {

using Rows = std::vector<const ordered_json*>;

Rows rows_of(const ordered_json& document, const std::string& task, const std::string& dataset) {
  Rows rows;
  for (const ordered_json& row : document.at("rows")) {
    if (row.at("task") == task && row.at("dataset") == dataset) rows.push_back(&row);
  }
  return rows;
}

std::string accuracy_table(const Rows& rows) {
  bool published = false;
  for (const ordered_json* row : rows) published = published || !row->at("published").is_null();
  std::vector<std::vector<std::string>> cells = {{"method", "senses", "seeds", "accuracy",
                                                  "less the chosen one's", "balanced",
                                                  "between seeds", "numbers", "time"}};
  if (published) cells.front().emplace_back("paper");
  for (const ordered_json* row : rows) {
    const ordered_json& accuracy = row->at("accuracy");
    cells.push_back({row->at("method"), row->at("senses"),
                     fmt::format("{}", row->at("seeds").size()), with_interval(accuracy),
                     row->at("chosen") == true ? "chosen" : with_interval(row->at("difference")),
                     with_interval(row->at("balanced_accuracy")),
                     accuracy.is_null() ? "-" : percent(accuracy.at("deviation")),
                     fmt::format("{}", row->at("parameters").get<std::int64_t>()),
                     core::human_duration(row->at("training_s"))});
    if (!published) continue;
    const ordered_json& theirs = row->at("published");
    cells.back().push_back(theirs.is_null() ? "-" : percent(theirs.at("accuracy")));
  }
  return markdown(cells);
}

/// Of those that only hear: how right their confidences are, and what they make of other sounds.
std::string recognition_table(const Rows& rows) {
  std::vector<std::vector<std::string>> cells = {
      {"method", "calibration error", "accepted", "of none of the classes",
       "area under the characteristic", "accepted of these"}};
  for (const ordered_json* row : rows) {
    const ordered_json& found = row->at("recognition");
    if (found.is_null()) continue;
    std::string method = row->at("method"), accepted = percent(found.at("accepted")),
                error = fmt::format("{} ({} by chance)", percent(found.at("calibration_error")),
                                    percent(found.at("calibration_by_chance")));
    for (const auto& [name, novel] : found.at("novel").items()) {
      cells.push_back(
          {method, error, accepted, name,
           with_interval({{"mean", novel.at("auroc")}, {"interval95", novel.at("auroc95")}}),
           percent(novel.at("accepted"))});
      method = error = accepted = "";
    }
  }
  return cells.size() == 1
             ? ""
             : "\nHow sure they are, and of what they are not (percent):\n\n" + markdown(cells);
}

/// Recall of each class, and which other it is taken for most often.
std::string recall_table(const ordered_json& row) {
  std::vector<std::vector<std::string>> cells = {
      {"class", "answers", "recall", "most often taken for"}};
  const auto classes = row.at("classes").get<std::vector<std::string>>();
  for (std::size_t c = 0; c < classes.size(); ++c) {
    const auto counts = row.at("confusion").at(c).get<std::vector<std::size_t>>();
    std::size_t all = 0, other = c;
    for (std::size_t k = 0; k < counts.size(); ++k) {
      all += counts[k];
      if (k != c && counts[k] > 0 && (other == c || counts[k] > counts[other])) other = k;
    }
    cells.push_back({classes[c], fmt::format("{}", all), percent(row.at("recalls").at(c)),
                     other == c ? "-" : fmt::format("{} ({})", classes[other], counts[other])});
  }
  return markdown(cells);
}

/// Of published sets that stand beside: what is not the same.
std::string differences(const ordered_json& document) {
  bool any = false;
  for (const ordered_json& row : document.at("rows")) {
    any = any || !row.at("published").is_null();
  }
  if (!any) return "";
  return "\nThe papers' column is of Sterling 2019, Tables 6.1 to 6.5, on other sounds: their "
         "bodies, "
         "materials' parameters and splits are not public, their layer sizes are not given, and "
         "their one run has no interval. VGG16 on pictures (Table 6.1) is left out: its pictures "
         "are not theirs or ours to give. Numbers may be compared in kind, not to the percent.\n";
}

}  // namespace

std::string classification_text(const ordered_json& document) {
  std::string text = fmt::format("# {}: classification\n", document.at("name").get<std::string>());
  for (const ordered_json& task : document.at("tasks")) {
    for (const ordered_json& dataset : document.at("datasets")) {
      const Rows rows = rows_of(document, task.at("name"), dataset.at("name"));
      if (rows.empty()) continue;
      const ordered_json& first = *rows.front();
      text += fmt::format("\n## {} of {}\n\n", task.at("name").get<std::string>(),
                          dataset.at("name").get<std::string>());
      text += fmt::format(
          "{} classes, {} samples of {} {} held out (`{}`); percent, with 95 % intervals over {} "
          "and, of several, seeds.\n\n",
          first.at("classes").size(), first.at("samples").get<std::size_t>(),
          first.at("groups").get<std::size_t>(), task.at("groups_are").get<std::string>(),
          task.at("split").get<std::string>(), task.at("groups_are").get<std::string>());
      text += accuracy_table(rows);
      text += recognition_table(rows);
      const ordered_json& best =
          **std::find_if(rows.begin(), rows.end(),
                         [](const ordered_json* row) { return row->at("chosen") == true; });
      text += fmt::format("\n{}, the best on the validation samples, by class:\n\n",
                          best.at("method").get<std::string>());
      text += recall_table(best);
    }
  }
  return text + differences(document);
}

std::string classification_csv(const ordered_json& document) {
  std::string csv = core::csv_line({"dataset",
                                    "task",
                                    "method",
                                    "senses",
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
  for (const ordered_json& row : document.at("rows")) {
    std::vector<std::string> cells;
    for (const char* name : {"dataset", "task", "method", "senses"}) {
      cells.push_back(row.at(name));
    }
    for (const char* name : {"seeds", "samples", "groups", "classes"}) {
      const ordered_json& value = row.at(name);
      cells.push_back(
          fmt::format("{}", value.is_array() ? value.size() : value.get<std::size_t>()));
    }
    for (const char* name : {"accuracy", "balanced_accuracy", "difference"}) {
      const ordered_json& summary = row.at(name);
      if (summary.is_null()) {
        cells.insert(cells.end(), 3, "");
        continue;
      }
      cells.push_back(core::csv_value(summary.at("mean")));
      for (const ordered_json& bound : summary.at("interval95")) {
        cells.push_back(core::csv_value(bound));
      }
    }
    const ordered_json& accuracy = row.at("accuracy");
    cells.push_back(accuracy.is_null() ? "" : core::csv_value(accuracy.at("deviation")));
    for (const char* name : {"validation_accuracy", "parameters", "training_s"}) {
      cells.push_back(core::csv_value(row.at(name)));
    }
    const ordered_json& theirs = row.at("published");
    cells.push_back(theirs.is_null() ? "" : theirs.at("set").get<std::string>());
    cells.push_back(theirs.is_null() ? "" : core::csv_value(theirs.at("accuracy")));
    csv += core::csv_line(cells);
  }
  return csv;
}

}  // namespace carillon::eval::studies
