#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/csv.hpp"
#include "eval/scoring/seed_answers.hpp"
#include "eval/scoring/test_set.hpp"

namespace carillon::eval::scoring {

/// What one method answered for a test set, trained with one seed or several.
struct ClassEntry {
  std::string name;
  bool has_probabilities = false;  ///< else classes alone
  std::vector<std::int64_t> seeds;
  std::vector<PartAnswers> answers;  ///< of each seed; scores are logarithms of probabilities
  std::vector<std::string> notes;    ///< what was passed over
};

/// Reads somebody's answers: a column `sample` (or `key`) with the samples' ids, and either
/// `class` or one column of probabilities for each class; `seed` where trainings of several seeds
/// answered. Answers for samples of other parts are passed over, and noted.
/// @throws InputError  a sample that is missing, there twice or not the dataset's; a class that
///                     there is not, a column that is missing or means nothing; probabilities that
///                     are not finite, negative or do not sum to 1 within 1 %: names the lines
ClassEntry read_class_entry(const core::CsvTable& table, const std::string& name,
                            const TestSet& set);

/// The entry's folder: `entry.json` and the files of answers that it names, one for each seed. An
/// entry of the same name is replaced, once this one is whole.
/// @throws StorageError
void keep_entry(const ClassEntry& entry, const TestSet& set, const std::filesystem::path& folder);

/// @throws FileError   it is not there, or damaged
///         InputError  it answered for another test set
ClassEntry kept_entry(const std::filesystem::path& folder, const TestSet& set);

/// All seeds' answers, to be summed up and compared.
SeedAnswers answers_of(const ClassEntry& entry, const TestSet& set);

/// How far confidences are from how often they are right, mean over seeds (calibration.hpp).
struct EntryCalibration {
  double error = 0, by_chance = 0;
};
/// NaN where there are no probabilities.
EntryCalibration calibration_of(const ClassEntry& entry, const TestSet& set);

}  // namespace carillon::eval::scoring
