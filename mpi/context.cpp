#include "mpi/context.hpp"

#include "mpi/comm.hpp"
#include "mpi/launcher.hpp"

namespace carillon::mpi {

bool Context::speaks() const {
  return world == MPI_COMM_NULL ? launcher_rank().value_or(0) == 0 : rank(world) == 0;
}

}  // namespace carillon::mpi
