#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/csv.hpp"
#include "eval/scoring/leaderboard.hpp"
#include "eval/scoring/object_truth.hpp"

namespace carillon::eval::scoring {

/// What is asked of each object that is held out.
enum class ObjectTask {
  damping,  ///< how fast its modes decay, by its material
  modes     ///< at which frequencies they are
};
std::string_view name_of(ObjectTask task);

/// One number of each object; NaN where an entry says nothing of it.
struct ObjectMeasure {
  std::string name, unit;  ///< as of Measure
  std::vector<double> values;
};

/// What one method said of the objects, held against the truth.
struct ObjectEntry {
  std::string name;
  std::vector<std::string> objects;     ///< their names
  std::vector<ObjectMeasure> measures;  ///< the first one ranks: the less the better
  std::vector<std::string> notes;
};

/// Holds somebody's answers against the truth. A column `object` names them, as far as it must to
/// be understood (`cup-3`, `cup-3/glass` or `cup-3/glass/1`), or `sample` one of their sounds, and
/// an object counts as the median of its sounds.
///
/// damping: one row with `alpha1` and `alpha2`, Rayleigh's (c = 2 d = alpha1 + alpha2 lambda), or a
/// row for each mode with `frequency_hz` and `decay_rate_per_s`. Of an object counts the median
/// over its true modes of |d / d_true - 1|; a mode that nothing is said of within 100 cents counts
/// as 1. Rates are the material's, without what supports or radiation add.
///
/// modes: a row for each mode with `frequency_hz`. Pairs within 100 cents, one answer for a mode,
/// of the most modes and the nearest of these. Of an object counts the median over its true modes
/// of the distance in cents; a mode without a partner counts as 100.
/// @throws InputError  an object that is missing, not there, or not told from others; a row twice;
///                     a number that is none; a column that is missing: names the lines
ObjectEntry score_objects(const core::CsvTable& table, const std::string& name, ObjectTask task,
                          const TrueObjects& truth);

/// `entry.json`: an entry of the same name is replaced.
/// @throws StorageError
void keep_entry(const ObjectEntry& entry, const std::filesystem::path& folder);

/// All entries that were kept, ranked by the median over objects. Told apart: Wilcoxon's signed
/// ranks of the objects' numbers, probabilities raised after Holm.
Leaderboard object_board(const std::filesystem::path& evaluation, ObjectTask task,
                         const TrueObjects& truth);

}  // namespace carillon::eval::scoring
