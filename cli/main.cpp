#include "cli/context.hpp"
#include "mpi/comm.hpp"
#include "mpi/interrupt.hpp"
#include "solvers/environment.hpp"

int main(int argc, char** argv) {
  carillon::mpi::leave_on_interrupt();
  const carillon::mpi::Environment mpi(argc, argv);
  const carillon::solvers::SolverEnvironment solvers;
  return carillon::cli::run(argc, argv, MPI_COMM_WORLD);
}
