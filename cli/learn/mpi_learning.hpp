#pragma once

#include <mpi.h>

#include "eval/learning/training.hpp"

namespace carillon::cli {

/// The ranks of a communicator as those that learn together.
eval::LearningRanks learning_ranks(MPI_Comm comm);

}  // namespace carillon::cli
