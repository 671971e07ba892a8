#pragma once

#include <mpi.h>

#include "solvers/modes/modes.hpp"

namespace carillon::solvers::modes {

/// Rank 0's modes on every rank.
/// @note Collective on comm.
void broadcast(Modes& modes, MPI_Comm comm);

}  // namespace carillon::solvers::modes
