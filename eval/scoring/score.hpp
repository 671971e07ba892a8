#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "eval/scoring/leaderboard.hpp"

namespace carillon::eval::scoring {

/// Answers of one method.
struct AnswersFile {
  std::filesystem::path path;  ///< CSV; or .npz, .npy or .parquet, where Python reads it
  std::string name;            ///< of the entry; "": the file's without its ending
};

/// What is to be scored on what.
struct ScoreRequest {
  std::filesystem::path dataset;
  /// `damping`, `modes`, a task of `tasks`, one that was scored before, or a column of labels.
  std::string task;
  std::vector<AnswersFile> answers;  ///< none: the board as it stands
  std::string tasks;                 ///< configuration with `train.tasks`; "": none
  std::filesystem::path seal;        ///< of an export that hides labels; "": none
  std::filesystem::path output;      ///< folder in place of the dataset's own; ""
  std::filesystem::path cache;       ///< as of require_clean_split()
};

/// What was found.
struct Scored {
  Leaderboard board;
  std::vector<nlohmann::ordered_json> entries;  ///< those that were handed in now, by class or mode
  std::vector<std::string> texts;               ///< the same for people
  std::filesystem::path folder;                 ///< where they are kept
};

/// Scores answers with the dataset's frozen split, keeps them in `evaluation/scores/TASK/NAME` and
/// writes the board of all that were ever handed in (leaderboard.hpp). Nothing is kept where one of
/// the answers is refused.
/// @throws InputError, ConfigError, FileError  as those that it is made of; names the file
Scored score(const ScoreRequest& request);

}  // namespace carillon::eval::scoring
