#pragma once

#include <vector>

#include "dataset/plan/plan.hpp"
#include "mpi/task_board.hpp"

namespace carillon::dataset::run {

/// What a rank holds between tasks [byte]. No part of a task's memory: what a node has free for
/// tasks is counted beside it.
constexpr double idle_rank_bytes = 1.3e8;

/// The plan's tasks with estimated seconds and memory, the width of their groups, and what comes
/// after what. Estimates are functions of the configuration and the files it names; a build
/// corrects the seconds by what its tasks take (mpi/calibration.hpp). Kinds are "modes", "modes of
/// groups" (wider than one rank) and "samples".
std::vector<mpi::Task> board_tasks(const plan::BuildPlan& plan,
                                   const configuration::BuildConfig& config);

}  // namespace carillon::dataset::run
