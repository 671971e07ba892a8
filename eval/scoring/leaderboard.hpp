#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "eval/scoring/seed_answers.hpp"

namespace carillon::eval::scoring {

/// One number that entries are told apart by.
struct Measure {
  std::string name;   ///< key in JSON, title of a column
  std::string unit;   ///< `%` of a share, `cent`, "" of a number
  Estimate estimate;  ///< interval NaN where there is none
};

/// How one entry did.
struct BoardRow {
  std::string entry;
  bool is_trained_here = false;  ///< a classifier of the configuration's own, not handed in
  std::size_t seeds = 1;
  std::vector<Measure> measures;       ///< the first one ranks
  std::optional<Estimate> difference;  ///< of the first measure from the first row's, on the same
                                       ///< samples or objects
  /// The difference from the first row is beyond what chance makes of any one of all rows
  /// (Bonferroni's level of the family 0.05).
  bool is_told_apart = false;
};

/// All entries of a task of a dataset, the best first.
struct Leaderboard {
  std::string dataset, task;
  std::string asked;  ///< what was asked of how many, for people
  bool more_is_better = true;
  std::vector<BoardRow> rows;
  std::vector<std::string> notes;  ///< of entries that could not be read
};

/// Folder of what was handed in for a task, in the dataset's `evaluation`; and those of its
/// entries.
std::filesystem::path entries_folder(const std::filesystem::path& evaluation,
                                     const std::string& task);
std::vector<std::filesystem::path> kept_entries(const std::filesystem::path& evaluation,
                                                const std::string& task);

/// Sorts by the first measure, NaN last, then by name.
void sort(Leaderboard& board);

/// docs/service.md names the fields.
nlohmann::ordered_json to_json(const Leaderboard& board);
/// A table for people, in Markdown.
std::string to_text(const Leaderboard& board);
std::string to_csv(const Leaderboard& board);

/// `leaderboard-TASK.json`, `.csv` and `.md`.
/// @throws StorageError
void write_board(const Leaderboard& board, const std::filesystem::path& folder);

}  // namespace carillon::eval::scoring
