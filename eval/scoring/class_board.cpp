#include "eval/scoring/class_board.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/error.hpp"
#include "core/json.hpp"
#include "eval/classification/calibration.hpp"
#include "eval/scoring/tables.hpp"

namespace carillon::eval::scoring {

namespace {

namespace fs = std::filesystem;
using classification::AccuracyKind;
using nlohmann::ordered_json;

/// One entry or one method's classifiers.
struct Contender {
  BoardRow row;
  SeedAnswers answers;
  double calibration_error = core::nan, calibration_by_chance = core::nan;
};

std::vector<fs::path> training_folders(const fs::path& models) {
  std::vector<fs::path> found;
  if (!fs::is_directory(models)) return found;
  for (const auto& entry : fs::recursive_directory_iterator(models)) {
    if (entry.path().filename() == "training.json") found.push_back(entry.path().parent_path());
  }
  std::sort(found.begin(), found.end());
  return found;
}

void add_entries(const fs::path& evaluation, const TestSet& set, std::vector<Contender>& all,
                 std::vector<std::string>& notes) {
  for (const fs::path& place : kept_entries(evaluation, set.task.name)) {
    try {
      const ClassEntry entry = kept_entry(place, set);
      const EntryCalibration calibration = calibration_of(entry, set);
      all.push_back({{entry.name, false, entry.seeds.size(), {}, {}, false},
                     answers_of(entry, set),
                     calibration.error,
                     calibration.by_chance});
    } catch (const core::Error& error) {
      notes.push_back(fmt::format("left out: {}", error.message()));
    }
  }
}

/// Classifiers of one method and settings, whose seeds alone differ.
struct TrainedMethod {
  std::string name;
  std::vector<fs::path> folders;
  double calibration_error = 0, calibration_by_chance = 0;
};

/// @param settings  text of all that the method is made of but its seed
void add_training(const fs::path& place, const TestSet& set,
                  std::map<std::string, TrainedMethod>& by_settings) {
  const nlohmann::json record = core::read_json(place / "training.json");
  if (!record.is_object()) return;
  // What another version of the program keeps otherwise is none of this task.
  if (learning::task_from(record.at("task")) != set.task) return;
  if (record.at("source_content") != set.content) return;
  nlohmann::json settings = record.at("method");
  const std::string name = settings.at("name");
  settings.at("learning").erase("seed");
  TrainedMethod& method = by_settings[settings.dump()];
  method.name = name;
  method.folders.push_back(place);
  const nlohmann::json recognition = record.value("recognition", nlohmann::json());
  const auto number = [&](const char* key) {
    return recognition.is_object() ? core::number_or_nan(recognition.at(key)) : core::nan;
  };
  method.calibration_error += number("calibration_error");
  method.calibration_by_chance += number("calibration_by_chance");
}

void add_trained(const fs::path& models, const TestSet& set, std::vector<Contender>& all,
                 std::vector<std::string>& notes) {
  std::map<std::string, TrainedMethod> by_settings;
  for (const fs::path& place : training_folders(models)) {
    try {
      add_training(place, set, by_settings);
    } catch (const nlohmann::json::exception&) {
      notes.push_back(fmt::format("left out: {} is of another version", place.string()));
    }
  }
  std::map<std::string, int> named;
  for (const auto& [settings, method] : by_settings) {
    const int number = ++named[method.name];
    Contender contender{{method.name, true, method.folders.size(), {}, {}, false},
                        SeedAnswers(set.task.split)};
    if (number > 1) contender.row.entry += fmt::format(" ({})", number);
    try {
      for (const fs::path& place : method.folders) {
        const Answers answers = read_answers(place / "answers.h5");
        contender.answers.add(answers.test, answers.classes);
      }
    } catch (const core::Error& error) {
      notes.push_back(fmt::format("left out: {}", error.message()));
      continue;
    }
    const auto seeds = static_cast<double>(method.folders.size());
    contender.calibration_error = method.calibration_error / seeds;
    contender.calibration_by_chance = method.calibration_by_chance / seeds;
    all.push_back(std::move(contender));
  }
}

/// Whether accuracy and balanced accuracy are the same number.
bool has_equal_classes(const TestSet& set) {
  std::vector<std::size_t> counts(set.classes.size());
  for (const std::int32_t label : set.asked.labels) ++counts[static_cast<std::size_t>(label)];
  return std::adjacent_find(counts.begin(), counts.end(), std::not_equal_to<>()) == counts.end();
}

void measure(Contender& contender, bool equal_classes) {
  const auto accuracy = [&](const char* name, AccuracyKind kind) {
    contender.row.measures.push_back(
        {name, "%", contender.answers.summary(kind, contender.row.entry).value()});
  };
  if (!equal_classes) accuracy("balanced accuracy", AccuracyKind::balanced);
  accuracy("accuracy", AccuracyKind::plain);
  if (std::isnan(contender.calibration_error)) return;
  const auto number = [&](const char* name, double value) {
    contender.row.measures.push_back({name, "%", {value, {core::nan, core::nan}}});
  };
  number("calibration error", contender.calibration_error);
  number("by chance", contender.calibration_by_chance);
}

/// An entry may be called as a method is.
using RowName = std::pair<bool, std::string>;
RowName name_of(const BoardRow& row) {
  return {row.is_trained_here, row.entry};
}

/// Whether a difference is below zero beyond a level of chance. Groups that differ all alike have
/// no variance: then as the sign test has it.
bool is_less(const SeedAnswers& own, const std::optional<Estimate>& difference, double level) {
  if (!difference || !(difference->mean < 0)) return false;
  if (!std::isnan(difference->interval95.high)) return difference->interval95.high < 0;
  return std::exp2(1 - static_cast<double>(own.groups())) < level;
}

void compare(std::vector<BoardRow>& rows, const std::map<RowName, SeedAnswers>& answers,
             AccuracyKind kind) {
  if (rows.size() < 2) return;
  const SeedAnswers& first = answers.at(name_of(rows.front()));
  const double others = static_cast<double>(rows.size() - 1);
  for (std::size_t r = 1; r < rows.size(); ++r) {
    const SeedAnswers& own = answers.at(name_of(rows[r]));
    rows[r].difference = own.less(first, kind);
    rows[r].is_told_apart = is_less(own, own.less(first, kind, 1 - 0.05 / others), 0.05 / others);
  }
}

std::string asked_of(const TestSet& set, const SeedAnswers* any) {
  return fmt::format(
      "{} classes of {} ({}), {} test samples{} (`{}`). Percent with 95 % intervals over these and "
      "seeds; the difference from the first is of the same samples, and told apart where it is "
      "beyond chance among all rows.",
      set.classes.size(), set.task.column, fmt::join(set.classes, ", "), set.asked.samples(),
      any == nullptr ? ""
                     : fmt::format(" of {} {}", any->groups(),
                                   set.task.split == "split_shape" ? "objects" : "strikes"),
      set.task.split);
}

}  // namespace

Leaderboard class_board(const fs::path& evaluation, const fs::path& models, const TestSet& set) {
  Leaderboard board{fs::path(set.dataset).filename().string(), set.task.name, "", true, {}, {}};
  std::vector<Contender> all;
  add_entries(evaluation, set, all, board.notes);
  add_trained(models, set, all, board.notes);
  const bool equal_classes = has_equal_classes(set);
  std::map<RowName, SeedAnswers> answers;
  for (Contender& contender : all) {
    measure(contender, equal_classes);
    answers.emplace(name_of(contender.row), contender.answers);
    board.rows.push_back(contender.row);
  }
  board.asked = asked_of(set, all.empty() ? nullptr : &all.front().answers);
  sort(board);
  compare(board.rows, answers, equal_classes ? AccuracyKind::plain : AccuracyKind::balanced);
  return board;
}

std::string entry_text(const ClassEntry& entry, const TestSet& set) {
  const SeedAnswers answers = answers_of(entry, set);
  const std::vector<double> recalls = classification::recalls(answers.confusion());
  std::vector<std::vector<std::string>> cells = {{"class", "recall", "taken for"}};
  for (std::size_t c = 0; c < set.classes.size(); ++c) {
    std::string taken;
    for (std::size_t k = 0; k < set.classes.size(); ++k) {
      const std::size_t count = answers.confusion().at(c, k);
      if (count == 0 || k == c) continue;
      taken += fmt::format("{}{} {}", taken.empty() ? "" : ", ", set.classes[k], count);
    }
    cells.push_back({set.classes[c], percent(recalls[c]), taken.empty() ? "-" : taken});
  }
  return fmt::format("{}: of {} test samples\n\n{}", entry.name, answers.samples(),
                     markdown(cells));
}

ordered_json entry_json(const ClassEntry& entry, const TestSet& set) {
  const SeedAnswers answers = answers_of(entry, set);
  const EntryCalibration calibration = calibration_of(entry, set);
  ordered_json recalls = ordered_json::array();
  for (const double recall : classification::recalls(answers.confusion())) {
    recalls.emplace_back(core::number_or_null(recall));
  }
  return {{"entry", entry.name},
          {"task", set.task.name},
          {"classes", set.classes},
          {"seeds", entry.seeds},
          {"samples", answers.samples()},
          {"groups", answers.groups()},
          {"accuracy", accuracy_json(answers.summary(AccuracyKind::plain, entry.name))},
          {"balanced_accuracy", accuracy_json(answers.summary(AccuracyKind::balanced, entry.name))},
          {"recalls", recalls},
          {"confusion", counts_json(answers.confusion())},
          {"calibration_error", core::number_or_null(calibration.error)},
          {"calibration_by_chance", core::number_or_null(calibration.by_chance)},
          {"notes", entry.notes}};
}

}  // namespace carillon::eval::scoring
