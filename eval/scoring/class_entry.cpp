#include "eval/scoring/class_entry.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <span>

#include "core/did_you_mean.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hash.hpp"
#include "core/json.hpp"
#include "core/text.hpp"
#include "eval/classification/calibration.hpp"
#include "eval/scoring/detail/first_few.hpp"

namespace carillon::eval::scoring {

namespace {

namespace fs = std::filesystem;

/// Of a probability that is 0, as 32 bits hold it.
constexpr float no_chance = -100;
/// By which rounded probabilities may miss 1.
constexpr double sum_tolerance = 0.01;
/// Where the table has what.
struct ClassColumns {
  std::size_t sample = 0;
  std::optional<std::size_t> answer, seed;
  std::vector<std::size_t> probabilities;  ///< of each class of the task
};

ClassColumns class_columns(const core::CsvTable& table, const TestSet& set) {
  const auto sample =
      table.column("sample").has_value() ? table.column("sample") : table.column("key");
  const std::string asks = fmt::format(
      "a column \"sample\" names the samples, and either \"class\" or one column for each of {} "
      "answers",
      fmt::join(set.classes, ", "));
  if (!sample) {
    throw core::InputError(fmt::format("{}: no column \"sample\"", table.head.place), asks);
  }
  ClassColumns columns{*sample, table.column("class"), table.column("seed"), {}};
  for (const std::string& name : table.head.cells) {
    const bool known = name == "sample" || name == "key" || name == "class" || name == "seed" ||
                       std::find(set.classes.begin(), set.classes.end(), name) != set.classes.end();
    if (known) continue;
    throw core::InputError(
        fmt::format("{}: column \"{}\" is none of the classes{}", table.head.place, name,
                    core::did_you_mean(name, set.classes)),
        asks);
  }
  if (columns.answer) return columns;
  std::vector<std::string> missing;
  for (const std::string& name : set.classes) {
    if (const auto column = table.column(name)) {
      columns.probabilities.push_back(*column);
    } else {
      missing.push_back(name);
    }
  }
  if (!missing.empty()) {
    throw core::InputError(fmt::format("{}: no column \"class\", and none of {}", table.head.place,
                                       fmt::join(missing, ", ")),
                           asks);
  }
  return columns;
}

const std::string& cell_of(const core::CsvRow& row, std::size_t column) {
  static const std::string none;
  return column < row.cells.size() ? row.cells[column] : none;
}

/// Logarithms of one row's probabilities.
std::vector<float> logarithms(const core::CsvRow& row, const ClassColumns& columns,
                              const TestSet& set) {
  std::vector<float> scores(set.classes.size(), no_chance);
  if (columns.answer) {
    const std::string& name = cell_of(row, *columns.answer);
    const auto at = std::find(set.classes.begin(), set.classes.end(), name);
    if (at == set.classes.end()) {
      throw core::InputError(fmt::format("{}: {} is no class of task {}{}", row.place,
                                         name.empty() ? "nothing" : "\"" + name + "\"",
                                         set.task.name, core::did_you_mean(name, set.classes)),
                             fmt::format("there are {}", fmt::join(set.classes, ", ")));
    }
    scores[static_cast<std::size_t>(at - set.classes.begin())] = 0;
    return scores;
  }
  double sum = 0;
  for (std::size_t c = 0; c < scores.size(); ++c) {
    const std::string& text = cell_of(row, columns.probabilities[c]);
    const std::optional<double> value = core::number_in<double>(text);
    if (!value || !(*value >= 0) || !std::isfinite(*value)) {
      throw core::InputError(
          fmt::format("{}: \"{}\" is no probability of {}", row.place, text, set.classes[c]));
    }
    sum += *value;
    if (*value > 0) scores[c] = std::max(no_chance, static_cast<float>(std::log(*value)));
  }
  if (std::abs(sum - 1) > sum_tolerance) {
    throw core::InputError(
        fmt::format("{}: probabilities sum to {:.4g}, not to 1", row.place, sum),
        "logits become probabilities by softmax; or answer with a column \"class\" alone");
  }
  return scores;
}

std::int64_t seed_of(const core::CsvRow& row, const ClassColumns& columns) {
  if (!columns.seed) return 0;
  const std::string& text = cell_of(row, *columns.seed);
  const std::optional<std::int64_t> seed = core::number_in<std::int64_t>(text);
  if (!seed || *seed < 0) {
    throw core::InputError(
        fmt::format("{}: seed \"{}\" is no whole number from 0 on", row.place, text));
  }
  return *seed;
}

void refuse(const std::vector<std::string>& places, const std::string& what,
            const std::string& hint) {
  if (!places.empty()) throw core::InputError(fmt::format("{}: {}", what, first_few(places)), hint);
}

/// Other answers have another name: those that stand there are kept until these are.
std::string answers_file(std::int64_t seed, const PartAnswers& answers) {
  core::Sha256 hash;
  for (const std::string& key : answers.keys) hash.add(key).add("\n");
  return fmt::format("answers-{}-{}.h5", seed,
                     hash.add(std::span(answers.scores)).hex().substr(0, 8));
}

}  // namespace

ClassEntry read_class_entry(const core::CsvTable& table, const std::string& name,
                            const TestSet& set) {
  const ClassColumns columns = class_columns(table, set);
  const std::size_t classes = set.classes.size();
  struct Given {
    PartAnswers answers;
    std::vector<std::string> place;  ///< of each sample; "": none yet
  };
  std::map<std::int64_t, Given> by_seed;
  std::vector<std::string> unknown, twice;
  std::map<learning::Part, std::size_t> other_parts;
  for (const core::CsvRow& row : table.rows) {
    const std::string& id = cell_of(row, columns.sample);
    const auto at = set.row_of.find(id);
    if (at == set.row_of.end()) {
      const auto other = set.part_of.find(id);
      if (other == set.part_of.end()) {
        unknown.push_back(fmt::format("\"{}\" ({})", id, row.place));
      } else {
        ++other_parts[other->second];
      }
      continue;
    }
    Given& given = by_seed[seed_of(row, columns)];
    if (given.place.empty()) {
      given.answers = set.asked;
      given.answers.scores.resize(set.asked.samples() * classes);
      given.place.resize(set.asked.samples());
    }
    std::string& place = given.place[at->second];
    if (!place.empty()) {
      twice.push_back(fmt::format("{} ({} and {})", id, place, row.place));
      continue;
    }
    place = row.place;
    const std::vector<float> scores = logarithms(row, columns, set);
    std::copy(scores.begin(), scores.end(),
              given.answers.scores.begin() + static_cast<std::ptrdiff_t>(at->second * classes));
  }
  refuse(unknown, fmt::format("{} samples that {} does not have", unknown.size(), set.dataset),
         "samples go by the column `key` of index.h5, or by the ids of a sealed export");
  refuse(twice, fmt::format("{} samples are answered twice", twice.size()),
         "one answer each; trainings of several seeds go in a column \"seed\"");
  if (by_seed.empty()) {
    throw core::InputError(fmt::format("{}: no answer for any of the {} test samples",
                                       table.head.place, set.row_of.size()));
  }
  ClassEntry entry{name, !columns.answer, {}, {}, {}};
  for (auto& [seed, given] : by_seed) {
    std::vector<std::string> missing;
    for (const auto& [id, row] : set.row_of) {
      if (given.place[row].empty()) missing.push_back(id);
    }
    refuse(
        missing,
        fmt::format("{}: {} of {} test samples have no answer{}", table.head.place, missing.size(),
                    set.row_of.size(), columns.seed ? fmt::format(" of seed {}", seed) : ""),
        "every test sample counts; answer the likeliest class where a method is unsure");
    entry.seeds.push_back(seed);
    entry.answers.push_back(std::move(given.answers));
  }
  for (const auto& [part, count] : other_parts) {
    entry.notes.push_back(fmt::format("{} answers for samples {} are passed over", count,
                                      part == learning::Part::train ? "to learn from"
                                      : part == learning::Part::validation
                                          ? "of the validation part"
                                          : "of the test part that are of none of the classes"));
  }
  return entry;
}

void keep_entry(const ClassEntry& entry, const TestSet& set, const fs::path& folder) {
  std::vector<std::string> files;
  for (std::size_t s = 0; s < entry.seeds.size(); ++s) {
    files.push_back(answers_file(entry.seeds[s], entry.answers[s]));
    write_answers(folder / files.back(), {set.classes, {}, entry.answers[s]});
  }
  const nlohmann::ordered_json about = {{"entry", entry.name},
                                        {"task", learning::to_json(set.task)},
                                        {"dataset_content", set.content},
                                        {"probabilities", entry.has_probabilities},
                                        {"seeds", entry.seeds},
                                        {"files", files},
                                        {"notes", entry.notes}};
  core::write_text_durably(folder / "entry.json", about.dump(1) + "\n");
  // What an earlier entry of that name answered.
  for (const auto& other : fs::directory_iterator(folder)) {
    const std::string name = other.path().filename().string();
    if (name.starts_with("answers-") &&
        std::find(files.begin(), files.end(), name) == files.end()) {
      fs::remove(other.path());
    }
  }
}

ClassEntry kept_entry(const fs::path& folder, const TestSet& set) {
  const nlohmann::json about = core::read_json(folder / "entry.json");
  const std::string hint = fmt::format("remove {}, and give the answers anew", folder.string());
  if (!about.is_object()) {
    throw core::FileError(fmt::format("{} is missing or damaged", (folder / "entry.json").string()),
                          hint);
  }
  ClassEntry entry;
  std::vector<std::string> files;
  try {
    entry.name = about.at("entry");
    entry.has_probabilities = about.at("probabilities");
    entry.seeds = about.at("seeds").get<std::vector<std::int64_t>>();
    files = about.at("files").get<std::vector<std::string>>();
    if (learning::task_from(about.at("task")) != set.task) {
      throw core::InputError(fmt::format("{} answered another task of that name", folder.string()),
                             hint);
    }
  } catch (const nlohmann::json::exception& error) {
    throw core::FileError(
        fmt::format("{} is damaged: {}", (folder / "entry.json").string(), error.what()), hint);
  }
  for (const std::string& file : files) {
    Answers answers = read_answers(folder / file);
    if (answers.classes != set.classes || answers.test.keys != set.asked.keys ||
        answers.test.labels != set.asked.labels) {
      throw core::InputError(
          fmt::format("{} answered for another state of the dataset", folder.string()), hint);
    }
    entry.answers.push_back(std::move(answers.test));
  }
  return entry;
}

SeedAnswers answers_of(const ClassEntry& entry, const TestSet& set) {
  SeedAnswers all(set.task.split);
  for (const PartAnswers& answers : entry.answers) all.add(answers, set.classes);
  return all;
}

EntryCalibration calibration_of(const ClassEntry& entry, const TestSet& set) {
  if (!entry.has_probabilities) return {core::nan, core::nan};
  EntryCalibration mean;
  for (const PartAnswers& answers : entry.answers) {
    const std::vector<double> scores(answers.scores.begin(), answers.scores.end());
    const std::vector<double> probabilities = classification::softmax({scores, set.classes.size()});
    const classification::ScoreRows rows{probabilities, set.classes.size()};
    core::RandomStream random(0, core::stable_hash(entry.name), "score.calibration");
    mean.error += classification::expected_calibration_error(
        classification::reliability(rows, true_classes(answers)));
    mean.by_chance += classification::calibration_error_by_chance(
        rows, groups_of(answers, set.task.split), random);
  }
  const auto seeds = static_cast<double>(entry.answers.size());
  return {mean.error / seeds, mean.by_chance / seeds};
}

}  // namespace carillon::eval::scoring
