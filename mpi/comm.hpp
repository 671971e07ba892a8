#pragma once

#include <mpi.h>

#include <exception>
#include <string>
#include <vector>

#include "core/handle.hpp"
#include "mpi/backoff.hpp"

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

/// Starts MPI with full thread support and ends it; the one object of a program.
/// @throws core::Error  the library gives less than MPI_THREAD_MULTIPLE, or MPI is running already
class Environment {
 public:
  Environment(int& argc, char**& argv);
  ~Environment();
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;
};

// Waiting for another rank costs no core here: every function below sleeps between its looks.

/// Any number of bytes of rank `root`, the same on every rank afterwards.
/// @param data  [bytes]
/// @note Collective.
void broadcast(void* data, std::size_t bytes, int root, MPI_Comm comm);

/// A text of rank `root`, the same on every rank afterwards.
/// @note Collective.
std::string broadcast(const std::string& text, int root, MPI_Comm comm);

/// Every rank's text, in rank order, on every rank.
/// @note Collective.
std::vector<std::string> all_gather(const std::string& text, MPI_Comm comm);

/// Ends a collective stage that may have failed on some ranks: when any rank brings an error, all
/// throw an error of the same kind with the message and hint of the lowest failing rank. Kinds
/// are those of core/failure.hpp; a TaskError keeps its stage.
///
/// @param error    what this rank's part threw, or null
/// @param timeout  [s] that a rank with an error waits for the others; where they have not come by
///                 then, they are stuck in a call that it will never make, and it ends the process
///                 by SIGABRT, with a message. Without end in a world, whose ranks may have long
///                 work of their own before they come.
/// @note Collective.
void agree(MPI_Comm comm, const std::exception_ptr& error, double timeout = endless);

/// The timeout within a group, whose ranks work at the same task and cannot get far without one.
constexpr double group_timeout = 60;  // [s]

/// Ends a task of a group, as `agree` ends a stage of it, for errors that came between the stages
/// too: a rank that is here early, with an error, takes part in the stages where the others are
/// until they have failed as well and come here.
/// @param timeout  as for `agree`
/// @note Collective.
void agree_at_end(MPI_Comm comm, const std::exception_ptr& error, double timeout = group_timeout);

/// What `work` threw, or null.
template <class Work>
std::exception_ptr error_of(Work&& work) {
  try {
    work();
  } catch (...) {
    return std::current_exception();
  }
  return nullptr;
}

/// Runs `work` and agrees on its outcome.
/// @note Collective.
template <class Work>
void agreed(MPI_Comm comm, Work&& work) {
  agree(comm, error_of(work));
}

/// The same for a stage of a task, on the ranks of its group. `work` may communicate itself.
/// @note Collective.
template <class Work>
void agreed_in_group(MPI_Comm comm, Work&& work) {
  agree(comm, error_of(work), group_timeout);
}

}  // namespace carillon::mpi
