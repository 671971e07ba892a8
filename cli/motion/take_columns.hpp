#pragma once

#include "cli/columns.hpp"
#include "cli/motion/take_maker.hpp"

namespace carillon::cli {

/// The columns of a take but for its audio: labels, poses, strikes, frames (docs/format.md).
void add_take_columns(const BuildConfig& config, const BuildPlan& plan, const Sample& sample,
                      const Take& take, Columns& columns);

}  // namespace carillon::cli
