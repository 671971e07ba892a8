#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "dataset/stored/stored_dataset.hpp"

namespace carillon::dataset::regenerate {

struct RegenerateOptions {
  std::string dataset;                 ///< folder
  std::vector<std::string> samples;    ///< row of index.h5, key or id
  std::vector<std::string> overrides;  ///< --set key=value: what is to change
  std::string inputs;                  ///< folder that paths of the configuration are meant from
  std::string output;                  ///< WAV file, a folder for several samples; "": none
  std::string cache{};                 ///< folder of meshes and modes; empty: none is kept
};

/// How a column of a sample that was made again differs from the stored one. null where a side does
/// not have it; long arrays are described, not written out.
struct ColumnDifference {
  std::string column{};
  nlohmann::json stored{}, made{};
  /// Of long arrays: energy of the difference over that of the stored values [dB].
  std::optional<double> difference_db{};
};

/// One sample, made again.
struct RegeneratedSample {
  std::string key{};
  std::uint64_t id = 0;
  bool stored = false;  ///< the dataset holds it
  std::vector<ColumnDifference> differences{};
  nlohmann::json record{};  ///< what was drawn, by column
  std::string wav{};        ///< file of its sound; "": none
  bool identical() const { return stored && differences.empty(); }
};

/// A shape whose modes were solved again.
struct SolvedAgain {
  std::string shape{}, why{};
};

struct Regenerated {
  std::string dataset{};               ///< folder
  std::vector<std::string> changed{};  ///< --set key=value
  std::vector<RegeneratedSample> samples{};
  stored::OtherVersions versions{};
  std::vector<std::string> doubts{};
  std::vector<SolvedAgain> modes{};
  /// Every sample is as it is stored; with --set, was made.
  bool as_expected() const;
};

/// Makes samples of a dataset again and compares each with what is stored.
/// @throws InputError  no dataset, no such sample, files that are needed are not there
Regenerated regenerate(const RegenerateOptions& options);

/// `samples[]`: key, id, stored, identical (null of one that is not stored), `differences[]`
/// (column, stored, made, difference_db), record, wav; `versions`: {name: {stored, here}};
/// `doubts[]`; `modes[]`: shape, why; dataset, changed
nlohmann::json to_json(const Regenerated& made);
/// For a person.
std::string regenerated_text(const Regenerated& made);

}  // namespace carillon::dataset::regenerate
