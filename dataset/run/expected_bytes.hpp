#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "dataset/run/build.hpp"

namespace carillon::dataset::run {

/// What a finished dataset's files come to [byte], by what they hold, compressed as they are
/// written. docs/scaling.md tells how near it is.
struct ExpectedBytes {
  double sounds = 0;    ///< shards: `audio`, `mel`, `touch` and all other columns
  double modes = 0;     ///< modes files but for voxels and pictures
  double voxels = 0;    ///< in modes files
  double pictures = 0;  ///< in modes files and as PNG files
  double movies = 0;    ///< in shards, and as MP4 files
  double wav = 0;
  double index = 0;    ///< index.h5
  double records = 0;  ///< dataset.json, croissant.json, journal.jsonl, trace.json and the like

  double total() const;
};

/// Depends on the configuration and the plan alone. Copies in inputs/ are not counted.
ExpectedBytes expected_bytes(const LoadedBuild& build);

/// `{sounds, modes, voxels, pictures, movies, wav, index, records}` [byte].
nlohmann::json to_json(const ExpectedBytes& bytes);
/// For a person: "sounds 10.4 MB, modes 8.4 MB, ..." of what there is.
std::string bytes_text(const ExpectedBytes& bytes);

}  // namespace carillon::dataset::run
