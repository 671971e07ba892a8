// The main() of every test program that runs on several ranks.
//
// Every rank runs every test. Rank 0 reports; the others print their failed checks alone, with
// their rank. At the end of a test the ranks agree on it: a check that failed on one rank fails
// the test on all, so that no rank goes on as if nothing had happened.
#include <gtest/gtest.h>
#include <mpi.h>

#include <cstdio>

#include "mpi/comm.hpp"

namespace {

class Agreement : public testing::EmptyTestEventListener {
  void OnTestEnd(const testing::TestInfo& test) override {
    const int failed_here = test.result()->Failed() ? 1 : 0;
    int failed_ranks = 0;
    MPI_Allreduce(&failed_here, &failed_ranks, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
    if (failed_ranks > 0 && failed_here == 0) {
      ADD_FAILURE() << "a check failed on " << failed_ranks << " other rank(s)";
    }
  }
};

class FailurePrinter : public testing::EmptyTestEventListener {
  void OnTestPartResult(const testing::TestPartResult& part) override {
    if (!part.failed()) return;
    std::fprintf(stderr, "[rank %d] %s:%d: %s\n", carillon::mpi::rank(MPI_COMM_WORLD),
                 part.file_name() != nullptr ? part.file_name() : "?", part.line_number(),
                 part.message());
  }
};

}  // namespace

int main(int argc, char** argv) {
  const carillon::mpi::Environment environment(argc, argv);
  testing::InitGoogleTest(&argc, argv);
  testing::TestEventListeners& listeners = testing::UnitTest::GetInstance()->listeners();
  if (carillon::mpi::rank(MPI_COMM_WORLD) != 0) {
    delete listeners.Release(listeners.default_result_printer());
    delete listeners.Release(listeners.default_xml_generator());
    listeners.Append(new FailurePrinter);
  }
  listeners.Append(new Agreement);
  const int failed_here = RUN_ALL_TESTS();
  int failed = 0;
  MPI_Allreduce(&failed_here, &failed, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  return failed;
}
