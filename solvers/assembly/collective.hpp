#pragma once

#include <mpi.h>

#include <exception>
#include <functional>

namespace carillon::solvers::assembly {

/// Runs this rank's part of a stage and agrees on its outcome: when it fails on any rank, every
/// rank throws an error of the same kind with the message of the lowest failing rank, so that none
/// waits in the next collective. `work` may communicate itself: a rank that fails in the middle of
/// it waits a minute for the others, and crashes (SIGABRT) with its message when they do not come.
/// @note Collective on comm.
void agreed(MPI_Comm comm, const std::function<void()>& work);

}  // namespace carillon::solvers::assembly
