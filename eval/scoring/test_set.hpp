#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dataset/exporters/seal.hpp"
#include "eval/learning/task.hpp"
#include "eval/scoring/answers.hpp"

namespace carillon::eval::scoring {

/// What is asked of anyone's method: the classes of a dataset's test samples.
struct TestSet {
  std::string dataset;  ///< its folder
  std::string content;  ///< hash of what it holds
  learning::TaskSpec task;
  std::vector<std::string> classes;
  PartAnswers asked;                              ///< without scores
  std::map<std::string, std::size_t> row_of;      ///< of each test sample, by the id that is asked
  std::map<std::string, learning::Part> part_of;  ///< of every other sample of the dataset
};

/// @param seal  of an export that hides its labels: samples are asked by its ids; else by their
///              keys
/// @param cache  as of require_clean_split()
/// @throws InputError  no such column, a split that leaks (require_clean_split()), no test samples,
///                     a seal of another dataset
///         FileError   no dataset, or shards that are missing
TestSet open_test_set(const std::filesystem::path& folder, const learning::TaskSpec& task,
                      const std::optional<dataset::exporters::Seal>& seal,
                      const std::filesystem::path& cache);

/// The task that a name stands for without a configuration: the classes of a column of texts.
/// @param name  `material`, `family`, `shape`, `label_NAME`; `geometry` is the column `shape`
learning::TaskSpec task_of_column(const std::string& name);

}  // namespace carillon::eval::scoring
