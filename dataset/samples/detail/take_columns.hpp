#pragma once

#include "core/columns.hpp"
#include "dataset/samples/take_maker.hpp"

namespace carillon::dataset::samples {

/// The columns of a take but for its audio: labels, poses, strikes, frames (docs/format.md).
void add_take_columns(const configuration::BuildConfig& config, const plan::BuildPlan& plan,
                      const plan::Sample& sample, const Take& take, core::Columns& columns);

}  // namespace carillon::dataset::samples
