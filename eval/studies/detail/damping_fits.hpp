#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "eval/studies/detail/sound_features.hpp"

namespace carillon::eval::studies {

/// All fits to sets of so many sounds of one material in one dataset.
struct FitBlock {
  std::size_t condition = 0;
  std::size_t source = 0;
  std::size_t material = 0;  ///< of the condition's
  std::size_t from = 0;      ///< of DampingValidation::from
  std::size_t sounds = 0;    ///< of each fit
  std::string key;           ///< for people: esprit/clean/steel/object/20
  std::string inputs;        ///< hash of all that decides the numbers
};

/// Sounds of a dataset by material and object, in the order of the plan.
class SoundsByObject {
 public:
  explicit SoundsByObject(const dataset::plan::BuildPlan& plan);
  /// Of each object of a material, at each of its sizes, numbers of its samples in the plan.
  const std::vector<std::vector<std::size_t>>& objects(const std::string& material) const;

 private:
  std::map<std::string, std::vector<std::vector<std::size_t>>> objects_;
};

/// What a fit can be made from, read when it is first asked for.
class FeatureStore {
 public:
  /// @param blocks  whose files are there; must outlive it
  /// @param keep_reverberant  as read_features() has it
  FeatureStore(const EvaluatedDatasets& datasets, const std::vector<SoundBlock>& blocks,
               bool keep_reverberant);
  /// By sample of the dataset's plan; one that could not be built, or looked at, is not there.
  const std::vector<SoundFeatures>& sounds(std::size_t condition, std::size_t source);
  /// Hash of all features of a dataset from one source.
  const std::string& content(std::size_t condition, std::size_t source);

 private:
  using Key = std::pair<std::size_t, std::size_t>;
  const EvaluatedDatasets& datasets_;
  const std::vector<SoundBlock>& blocks_;
  bool keep_reverberant_;
  std::map<Key, std::vector<SoundFeatures>> sounds_;
  std::map<Key, std::string> contents_;
};

std::vector<FitBlock> fit_blocks(const DampingValidation& validation,
                                 const EvaluatedDatasets& datasets, FeatureStore& store);

/// What came of a block, by estimator.
struct BlockFits {
  std::string inputs, block;  ///< of the block, its key
  double points = 0;          ///< median of the fits
  /// For each draw the parameters; none where there is no fit.
  std::map<std::string, std::vector<std::vector<double>>> fits;
  std::map<std::string, std::string> why;  ///< what the first fit that failed met
};

/// A line of damping-fits.jsonl.
nlohmann::json to_json(const BlockFits& fits);
BlockFits fits_from(const nlohmann::json& line);

/// Of every block, in the order of the blocks; nothing where it failed.
using FitResults = std::vector<std::optional<BlockFits>>;

/// Draws the sets of sounds, the same for every dataset and source of features where the same
/// sounds are there, and fits all of them by every estimator.
BlockFits compute_fits(const FitBlock& block, const DampingValidation& validation,
                       const EvaluatedDatasets& datasets, FeatureStore& store);

}  // namespace carillon::eval::studies
