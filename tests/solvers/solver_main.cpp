// Runs tests with MPI and SLEPc alive; a failure on any rank fails every rank.
#include <gtest/gtest.h>
#include <mpi.h>

#include <optional>

#include "core/termination_blocked.hpp"
#include "solvers/environment.hpp"

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  int provided = 0;
  std::optional<carillon::core::TerminationBlocked> blocked(std::in_place);
  MPI_Init_thread(&argc, &argv, MPI_THREAD_MULTIPLE, &provided);
  blocked.reset();
  int failed = 0;
  {
    const carillon::solvers::SolverEnvironment environment;
    failed = RUN_ALL_TESTS();
    MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  }
  MPI_Finalize();
  return failed;
}
