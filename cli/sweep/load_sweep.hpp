#pragma once

#include <optional>

#include "cli/build/build.hpp"
#include "cli/sweep/sweep.hpp"

namespace carillon::cli {

/// A sweep as every rank sees it: each variant is the build that its overrides, after those of
/// --set, make of the configuration.
struct LoadedSweep {
  std::string name;  ///< the configuration's, also the default folder
  Sweep sweep;
  std::vector<LoadedBuild> builds;  ///< one per variant
};

/// Reads on rank 0 and expands every variant; nothing where the configuration has no `sweep`.
/// @throws ConfigError, FileError  on every rank alike; what is wrong with a variant names the line
///         of the value in `sweep`
/// @note Collective on world.
std::optional<LoadedSweep> load_sweep(const BuildOptions& options, MPI_Comm world);

}  // namespace carillon::cli
