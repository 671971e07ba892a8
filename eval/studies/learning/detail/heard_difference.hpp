#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/hdf5.hpp"
#include "eval/networks/training.hpp"
#include "eval/perception/compare_sounds.hpp"

namespace carillon::eval::studies {

/// The sounds of a dataset by their keys, each taken apart once.
class KeyedSounds {
 public:
  /// @throws FileError  not readable
  KeyedSounds(const std::filesystem::path& folder, std::size_t listener);

  /// Of what is heard: velocity or pressure.
  std::string unit() const;
  /// @throws InputError  no sound of this key
  const perception::HeardSound& hear(const std::string& key);

 private:
  core::Hdf5Group file_;
  std::size_t listener_, listeners_ = 1;
  std::map<std::string, std::size_t> rows_;
  std::map<std::string, perception::HeardSound> heard_;
};

/// How different the same strikes sound in two datasets, in numbers that stand for the papers'
/// listeners (Sterling 2019, section 4.3). Medians over sounds; NaN where nothing can be compared.
struct HeardDifference {
  std::size_t sounds = 0;  ///< compared; silent ones are not
  /// Errors of modes, of each sound the mean weighted by prominence, in just-noticeable
  /// differences.
  double pitch = 0, decay = 0;
  double level = 0;     ///< likewise; NaN where one is velocity and the other pressure
  double matched = 0;   ///< fraction of the reference's energy in modes that the other has, too
  double loudness = 0;  ///< rms difference in sone/Bark over the rms of the two sounds' own, 0 to
                        ///< sqrt(2); of velocity and pressure at equal energies
};

nlohmann::ordered_json to_json(const HeardDifference& difference);

/// @param keys  samples that both datasets have
/// @throws FileError  not readable
/// @note Collective on the ranks, who share the sounds.
HeardDifference heard_difference(KeyedSounds& reference, const std::filesystem::path& other,
                                 const std::vector<std::string>& keys, std::size_t listener,
                                 const networks::LearningRanks& ranks);

}  // namespace carillon::eval::studies
