#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "eval/learning/training.hpp"

namespace carillon::cli {

/// How different the same strikes sound in two datasets, in numbers that stand for the papers'
/// listeners (Sterling 2019, section 4.3). Medians over sounds; NaN where nothing can be compared.
struct HeardDifference {
  std::size_t sounds = 0;  ///< compared; silent ones are not
  /// Errors of modes, of each sound the mean weighted by prominence, in just-noticeable
  /// differences.
  double pitch = 0, decay = 0;
  double level = 0;     ///< likewise; NaN where one is velocity and the other pressure
  double matched = 0;   ///< share of the reference's energy in modes that the other has, too
  double loudness = 0;  ///< rms difference in sone/Bark over the rms of the two sounds' own, 0 to
                        ///< sqrt(2); of velocity and pressure at equal energies
};

nlohmann::ordered_json to_json(const HeardDifference& difference);

/// @param keys  samples that both datasets have
/// @throws FileError  not readable
/// @note Collective on the ranks, who share the sounds.
HeardDifference heard_difference(const std::filesystem::path& reference,
                                 const std::filesystem::path& other,
                                 const std::vector<std::string>& keys, std::size_t listener,
                                 const eval::LearningRanks& ranks);

}  // namespace carillon::cli
