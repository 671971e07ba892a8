#pragma once

#include <mpi.h>

#include <exception>
#include <string>
#include <vector>

#include "core/handle.hpp"

namespace carillon::mpi {

/// MPI_Comm_free that lets MPI_COMM_NULL pass, which MPI_Comm_split hands to ranks left out.
int free_comm(MPI_Comm* comm);

/// Owner of a communicator that was made by this program. Freeing is collective.
using Comm = core::Handle<MPI_Comm, free_comm, nullptr>;

/// A communicator of the same ranks whose messages meet no others.
/// @note Collective.
Comm duplicate(MPI_Comm comm);

int rank(MPI_Comm comm);
int size(MPI_Comm comm);

/// Starts MPI with full thread support and ends it; the one object of main().
/// @throws core::Error  the library gives less than MPI_THREAD_MULTIPLE, or MPI is running already
class Environment {
 public:
  Environment(int& argc, char**& argv);
  ~Environment();
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;
};

// Waiting for another rank costs no core here: every function below sleeps between its looks.

/// A text of rank `root`, the same on every rank afterwards.
/// @note Collective.
std::string broadcast(const std::string& text, int root, MPI_Comm comm);

/// Every rank's text, in rank order, on every rank.
/// @note Collective.
std::vector<std::string> all_gather(const std::string& text, MPI_Comm comm);

/// Ends a collective stage that may have failed on some ranks: when any rank brings an error, all
/// throw an error of the same kind with the message and hint of the lowest failing rank. Kinds
/// are ConfigError, InputError, LimitError, SolverError, FileError and, for everything else, Error.
/// @param error  what this rank's part threw, or null
/// @note Collective.
void agree(MPI_Comm comm, const std::exception_ptr& error);

/// Runs `work` and agrees on its outcome.
/// @note Collective.
template <class Work>
void agreed(MPI_Comm comm, Work&& work) {
  std::exception_ptr error;
  try {
    work();
  } catch (...) {
    error = std::current_exception();
  }
  agree(comm, error);
}

}  // namespace carillon::mpi
