#include "cli/context.hpp"

#include "mpi/comm.hpp"
#include "mpi/launcher.hpp"

namespace carillon::cli {

bool Context::speaks() const {
  return world == MPI_COMM_NULL ? mpi::launcher_rank().value_or(0) == 0 : mpi::rank(world) == 0;
}

}  // namespace carillon::cli
