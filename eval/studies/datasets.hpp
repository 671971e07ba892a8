#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/config.hpp"
#include "dataset/sweep/load_sweep.hpp"
#include "eval/learning/recordings_source.hpp"

namespace carillon::eval::studies {

/// One dataset that is evaluated: a variant of a sweep, the build itself, or a folder that is
/// there.
struct Condition {
  std::string name;  ///< the variant's values, "noise and room"; of a build its own
  std::filesystem::path folder;
  std::string place{};  ///< folder among those of its sweep; "" where it is alone
  const dataset::run::LoadedBuild* build = nullptr;  ///< null: the configuration does not build it
  std::optional<learning::RecordingsSpec> recordings{};  ///< it is these, not a dataset
};

/// What `data` or `recordings` of a mapping name; nothing where it has neither.
/// @param config  file that their paths are meant from
/// @throws ConfigError  no dataset there, or no way to read the recordings' labels
std::optional<Condition> read_given(core::ConfigNode& node, const std::string& name,
                                    const std::string& config);

/// The datasets of a configuration, before or after they are built; with a key `data` the dataset
/// whose folder it names, with `recordings` sounds of the user's own.
class EvaluatedDatasets {
 public:
  /// Reads the configuration and plans every dataset that is its own.
  /// @throws ConfigError, InputError, FileError  on every rank alike
  /// @note Collective on world.
  EvaluatedDatasets(const dataset::run::BuildOptions& options, MPI_Comm world);
  EvaluatedDatasets(const EvaluatedDatasets&) = delete;
  EvaluatedDatasets& operator=(const EvaluatedDatasets&) = delete;

  const std::string& name() const { return name_; }
  const dataset::run::BuildOptions& options() const { return options_; }
  /// The configuration's file.
  const std::string& config() const { return options_.config; }
  /// Of all datasets together; what is found goes into `evaluation` in it.
  const std::filesystem::path& output() const { return output_; }
  const std::vector<Condition>& conditions() const { return conditions_; }
  /// For meshes, modes and room responses; what a build without a cache of the user's keeps.
  std::filesystem::path cache() const;

  /// Builds what is not there yet.
  /// @return exit code of `carillon build`
  /// @note Collective on world.
  int build(MPI_Comm world) const;

 private:
  void plan(MPI_Comm world);

  dataset::run::BuildOptions options_;
  std::string name_;
  std::filesystem::path output_;
  std::optional<dataset::sweep::LoadedSweep> sweep_;
  std::optional<dataset::run::LoadedBuild> build_;
  std::vector<Condition> conditions_;
};

}  // namespace carillon::eval::studies
