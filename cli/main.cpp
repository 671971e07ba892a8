#include "cli/context.hpp"
#include "cli/learn/commands.hpp"
#include "cli/learn/learn_program.hpp"
#include "mpi/comm.hpp"
#include "mpi/interrupt.hpp"
#include "solvers/environment.hpp"

int main(int argc, char** argv) {
  carillon::mpi::leave_on_interrupt();
  carillon::cli::become_learner(argv);
  const carillon::mpi::Environment mpi(argc, argv);
  const carillon::solvers::SolverEnvironment solvers;
  constexpr carillon::cli::AddCommand commands[] = {carillon::cli::add_missing_train,
                                                    carillon::cli::add_missing_identify,
                                                    carillon::cli::add_plain_evaluate};
  return carillon::cli::run(argc, argv, MPI_COMM_WORLD, commands);
}
