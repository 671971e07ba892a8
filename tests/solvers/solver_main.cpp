// Runs tests with MPI and SLEPc alive; a failure on any rank fails every rank.
#include <gtest/gtest.h>
#include <mpi.h>

#include "mpi/comm.hpp"
#include "solvers/libraries/environment.hpp"

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  const carillon::mpi::Environment mpi(argc, argv);
  const carillon::solvers::libraries::SolverEnvironment solvers;
  int failed = RUN_ALL_TESTS();
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  return failed;
}
