#pragma once

#include <mpi.h>

#include "eval/networks/training.hpp"

namespace carillon::eval::studies {

/// The ranks of a communicator as those that learn together.
networks::LearningRanks learning_ranks(MPI_Comm comm);

}  // namespace carillon::eval::studies
