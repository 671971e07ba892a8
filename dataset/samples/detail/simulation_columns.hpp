#pragma once

#include "core/columns.hpp"
#include "dataset/samples/simulation_maker.hpp"

namespace carillon::dataset::samples {

/// The columns of a simulation but for its audio: labels, poses, strikes, frames (docs/format.md).
void add_simulation_columns(const configuration::BuildConfig& config, const plan::BuildPlan& plan,
                            const plan::Sample& sample, const Simulation& simulation,
                            core::Columns& columns);

}  // namespace carillon::dataset::samples
