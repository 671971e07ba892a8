#include "solvers/assembly/collective.hpp"

#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <utility>

#include "core/failure.hpp"

namespace carillon::solvers::assembly {
namespace {

/// As mpi::broadcast has it, so that a rank in mpi::agree_at_end understands.
std::string broadcast(std::string text, int root, MPI_Comm comm) {
  std::uint64_t length = text.size();
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibcast(&length, 1, MPI_UINT64_T, root, comm, &request);
  MPI_Wait(&request, MPI_STATUS_IGNORE);
  text.resize(length);
  MPI_Ibcast(text.data(), static_cast<int>(length), MPI_CHAR, root, comm, &request);
  MPI_Wait(&request, MPI_STATUS_IGNORE);
  return text;
}

/// Completes a request, unless the other ranks are stuck where this one failed.
void wait_or_abort(MPI_Request& request, const std::exception_ptr& error, int rank) {
  if (!error) {
    MPI_Wait(&request, MPI_STATUS_IGNORE);
    return;
  }
  constexpr auto patience = std::chrono::seconds(60);
  const auto start = std::chrono::steady_clock::now();
  int done = 0;
  for (MPI_Test(&request, &done, MPI_STATUS_IGNORE); done == 0;
       MPI_Test(&request, &done, MPI_STATUS_IGNORE)) {
    if (std::chrono::steady_clock::now() - start > patience) {
      std::fprintf(stderr, "carillon: rank %d: %s; the other ranks cannot go on without it\n", rank,
                   core::describe(error).message.c_str());
      // A crash: whoever watches over the task counts it as one.
      std::abort();
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace

void agreed(MPI_Comm comm, const std::function<void()>& work) {
  std::exception_ptr error;
  try {
    work();
  } catch (...) {
    error = std::current_exception();
  }
  int rank = 0, size = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &size);
  // The second number tells a stage of a task (0) from its end (mpi/comm.cpp).
  std::array<int, 2> failing{error ? rank : size, 0};
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Iallreduce(MPI_IN_PLACE, failing.data(), 2, MPI_INT, MPI_MIN, comm, &request);
  wait_or_abort(request, error, rank);
  if (failing[0] == size) return;
  std::string record;
  if (rank == failing[0]) record = core::to_record(core::describe(error));
  core::raise(core::from_record(broadcast(std::move(record), failing[0], comm)));
}

}  // namespace carillon::solvers::assembly
