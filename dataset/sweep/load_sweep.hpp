#pragma once

#include <optional>

#include "dataset/run/build.hpp"
#include "dataset/sweep/sweep.hpp"

namespace carillon::dataset::sweep {

/// A sweep as every rank sees it: each variant is the build that its overrides, after those of
/// --set, make of the configuration.
struct LoadedSweep {
  std::string name;  ///< the configuration's, also the default folder
  Sweep sweep;
  std::vector<run::LoadedBuild> builds;  ///< one per variant
};

/// Reads on rank 0 and expands every variant; nothing where the configuration has no `sweep`.
/// @throws ConfigError, FileError  on every rank alike; what is wrong with a variant names the line
///         of the value in `sweep`
/// @note Collective on world.
std::optional<LoadedSweep> load_sweep(const run::BuildOptions& options, MPI_Comm world);

}  // namespace carillon::dataset::sweep
