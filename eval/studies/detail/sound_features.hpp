#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "eval/studies/detail/damping_validation.hpp"

namespace carillon::eval::studies {

/// Sounds of one shard whose features are computed and kept together.
struct SoundBlock {
  std::size_t condition = 0;
  std::size_t source = 0;
  std::size_t task = 0;              ///< of the dataset's plan
  std::size_t first = 0, count = 0;  ///< rows of the shard
  std::filesystem::path shard;
  std::string key;  ///< for people: esprit/clean/samples/cup-000-0000+64
  /// Its name is a hash of the shard, the rows, the options and the program's version: what is
  /// there was computed from the same, and is not computed again.
  std::filesystem::path file;
};

/// All sounds of the datasets, as dataset.json lists their shards, for every source of features.
/// @param folder  of the files; those of equal contents have the same name
/// @throws FileError  a dataset.json cannot be read
std::vector<SoundBlock> sound_blocks(const EvaluatedDatasets& datasets,
                                     const std::vector<FeatureSource>& sources,
                                     const std::filesystem::path& folder);

/// Features of a block's sounds, into its file. Where a sound was recorded in a room, what decays
/// faster than that room, in the octave of the feature, is marked.
/// @param cache  of the builds
void compute_features(const SoundBlock& block, const Condition& condition,
                      const FeatureSource& source, const std::filesystem::path& cache);

/// What the features of one sound come to.
struct SoundFeatures {
  bool there = false;           ///< the sound was built, and looked at
  damping::DampingData data;    ///< of those that can be relied on
  std::size_t found = 0;        ///< features
  std::size_t reverberant = 0;  ///< of these: may be the room's
};

/// @param keep_reverberant  rely on features that may be the room's, too
/// @throws FileError
std::vector<SoundFeatures> read_features(const std::filesystem::path& file, bool keep_reverberant);
/// Hash of the features in a file.
std::string content_of(const std::filesystem::path& file);

}  // namespace carillon::eval::studies
