// Run by themselves and expected to fail (see CMakeLists.txt): a check that fails on one rank must
// fail the program.
#include <gtest/gtest.h>

#include "mpi/comm.hpp"

namespace carillon::mpi {
namespace {

TEST(MpiMain, DISABLED_FailsOnTheLastRankOnly) {
  EXPECT_NE(rank(MPI_COMM_WORLD), size(MPI_COMM_WORLD) - 1);
}

}  // namespace
}  // namespace carillon::mpi
