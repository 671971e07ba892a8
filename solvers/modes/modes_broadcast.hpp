#pragma once

#include <mpi.h>

#include "solvers/modes/modes.hpp"

namespace carillon::solvers::modes {

/// A rank's modes on every rank.
/// @note Collective on comm.
void broadcast(Modes& modes, MPI_Comm comm, int root = 0);

}  // namespace carillon::solvers::modes
