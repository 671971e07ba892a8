#pragma once

#include "dataset/sweep/load_sweep.hpp"

namespace carillon::dataset::sweep {

/// Builds every variant into a folder of its own below the sweep's, all on one board, or carries on
/// where an earlier run stopped; then writes sweep.csv, sweep.json, sweep-timing.csv and
/// trace.json.
/// @return exit code
/// @note Collective on world.
int run_sweep(const LoadedSweep& loaded, const run::BuildOptions& options, MPI_Comm world);

}  // namespace carillon::dataset::sweep
