#pragma once

#include <filesystem>

#include "eval/scoring/class_entry.hpp"
#include "eval/scoring/leaderboard.hpp"

namespace carillon::eval::scoring {

/// Everything that was answered for a test set: entries that were kept (keep_entry()), and the
/// classifiers that `carillon train` and `evaluate` trained on this dataset for the same task.
/// Ranked by accuracy, where classes have unequally many samples by balanced accuracy.
/// @param evaluation  folder with the entries
/// @param models      folder that may have trainings, at any depth
Leaderboard class_board(const std::filesystem::path& evaluation,
                        const std::filesystem::path& models, const TestSet& set);

/// One entry for people, in Markdown: recalls and confusions.
std::string entry_text(const ClassEntry& entry, const TestSet& set);
/// `score.json`: the same as numbers, with the bins of the reliability diagram.
nlohmann::ordered_json entry_json(const ClassEntry& entry, const TestSet& set);

}  // namespace carillon::eval::scoring
