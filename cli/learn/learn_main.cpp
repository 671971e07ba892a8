// carillon-learn: carillon with the commands that need libtorch; carillon starts it.
#include "cli/context.hpp"
#include "cli/learn/commands.hpp"
#include "eval/learning/training.hpp"
#include "mpi/comm.hpp"
#include "mpi/interrupt.hpp"
#include "solvers/environment.hpp"

int main(int argc, char** argv) {
  carillon::mpi::leave_on_interrupt();
  // More ranks with one thread each are faster than one rank with more.
  carillon::eval::use_learning_threads(1);
  const carillon::mpi::Environment mpi(argc, argv);
  const carillon::solvers::SolverEnvironment solvers;
  constexpr carillon::cli::AddCommand commands[] = {
      carillon::cli::add_train, carillon::cli::add_identify, carillon::cli::add_full_evaluate};
  return carillon::cli::run(argc, argv, MPI_COMM_WORLD, commands);
}
