#include "solvers/collective.hpp"

#include <chrono>
#include <cstdio>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include "core/error.hpp"

namespace carillon::solvers {
namespace {

enum Kind : int { input, solver, limit, time, memory, file, other };

struct Failure {
  int kind = other;
  std::string message;
  std::string hint;
};

Failure describe(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const core::InputError& e) {
    return {input, e.message(), e.hint()};
  } catch (const core::FileError& e) {
    return {file, e.message(), e.hint()};
  } catch (const core::LimitError& e) {
    return {limit, e.message(), e.hint()};
  } catch (const core::TimeError& e) {
    return {time, e.message(), e.hint()};
  } catch (const core::MemoryError& e) {
    return {memory, e.message(), e.hint()};
  } catch (const core::SolverError& e) {
    return {solver, e.message(), e.hint()};
  } catch (const core::Error& e) {
    return {other, e.message(), e.hint()};
  } catch (const std::bad_alloc&) {
    return {memory, "out of memory", ""};
  } catch (const std::exception& e) {
    return {other, e.what(), ""};
  }
}

void broadcast(std::string& text, int root, MPI_Comm comm) {
  auto length = static_cast<unsigned long>(text.size());
  MPI_Bcast(&length, 1, MPI_UNSIGNED_LONG, root, comm);
  text.resize(length);
  MPI_Bcast(text.data(), static_cast<int>(length), MPI_CHAR, root, comm);
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
                   describe(error).message.c_str());
      MPI_Abort(MPI_COMM_WORLD, 1);
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
  int failing = error ? rank : size;
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Iallreduce(MPI_IN_PLACE, &failing, 1, MPI_INT, MPI_MIN, comm, &request);
  wait_or_abort(request, error, rank);
  if (failing == size) return;
  Failure failure;
  if (rank == failing) failure = describe(error);
  MPI_Bcast(&failure.kind, 1, MPI_INT, failing, comm);
  broadcast(failure.message, failing, comm);
  broadcast(failure.hint, failing, comm);
  switch (failure.kind) {
    case input:
      throw core::InputError(failure.message, failure.hint);
    case solver:
      throw core::SolverError(failure.message, failure.hint);
    case limit:
      throw core::LimitError(failure.message, failure.hint);
    case time:
      throw core::TimeError(failure.message, failure.hint);
    case memory:
      throw core::MemoryError(failure.message, failure.hint);
    case file:
      throw core::FileError(failure.message, failure.hint);
    default:
      throw core::Error(failure.message, failure.hint);
  }
}

}  // namespace carillon::solvers
