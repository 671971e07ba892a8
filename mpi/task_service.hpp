#pragma once

#include <mpi.h>

#include <functional>
#include <memory>

#include "mpi/task_board.hpp"

namespace carillon::mpi {

/// Called on the host rank, from the service's thread, one call at a time.
struct ServiceHooks {
  /// A task ended; `outcome.record` goes to the journal here.
  std::function<void(const Task&, const Outcome&)> completed;
  /// After every claim and completion.
  std::function<void(const TaskBoard&)> progress;
};

/// The shared task queue. Rank 0 hosts the board in a helper thread that answers plain messages
/// in milliseconds while its own rank computes; no rank is lost to being a master.
class TaskService {
 public:
  /// @param board  rank 0's is used; others may pass an empty one
  /// @note Collective on world.
  TaskService(MPI_Comm world, TaskBoard board, ServiceHooks hooks);
  /// @note Collective: waits until every rank's groups have seen the end.
  ~TaskService();

  /// Next task for a group of `width` ranks; called by the group's leader alone. Sleeps while
  /// tasks are pending that wait for others.
  Claim next(int width);
  void complete(std::int64_t task, const Outcome& outcome);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Runs tasks until none is left: groups of `group_width` ranks first while tasks of that width
/// exist, then single ranks. `work` is called on every rank of the group with the task's index and
/// the group's communicator; what it throws becomes a failed outcome, agreed on in the group.
/// @param work  returns the journal record (leader's is used)
/// @note Collective on world.
void run_tasks(MPI_Comm world, TaskBoard board, ServiceHooks hooks, int group_width,
               const std::function<std::string(std::int64_t, MPI_Comm)>& work);

}  // namespace carillon::mpi
