#pragma once

#include "dataset/run/schedule.hpp"
#include "dataset/sweep/load_sweep.hpp"

namespace carillon::dataset::sweep {

/// Builds every variant into a folder of its own below the sweep's, all on one board, or carries on
/// where an earlier run stopped; then writes sweep.csv, sweep.json, sweep-timing.csv and
/// trace.json.
/// @return exit code
/// @note Collective on the context's world.
int run_sweep(const LoadedSweep& loaded, const run::BuildOptions& options,
              const mpi::Context& context);

/// What `carillon plan` tells of a sweep: its variants, what they share, what all of it costs, and
/// how it would go on ranks that are asked for.
void tell_sweep_plan(const LoadedSweep& loaded, const run::ScheduleOptions& schedule, bool as_json);

}  // namespace carillon::dataset::sweep
