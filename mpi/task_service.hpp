#pragma once

#include <mpi.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "mpi/task_board.hpp"
#include "mpi/task_host.hpp"

namespace carillon::mpi {

/// The shared task queue. Rank 0 hosts the board in a helper thread that answers plain messages
/// in milliseconds while its own rank computes; no rank is lost to being a master. Nobody holds a
/// core while waiting, neither the idle service nor a rank that waits for its answer.
class TaskService {
 public:
  /// @param board  rank 0's is used; others may pass an empty one
  /// @param hooks  rank 0's are called
  /// @throws core::Error  the thread cannot be started, on all ranks alike
  /// @note Collective on world.
  TaskService(MPI_Comm world, TaskBoard board, ServiceHooks hooks);
  /// Finishes, but keeps errors to itself.
  /// @note Collective.
  ~TaskService();
  TaskService(const TaskService&) = delete;
  TaskService& operator=(const TaskService&) = delete;

  /// Next task for a group of `width` ranks; called by the group's leader alone. Sleeps while
  /// tasks are pending that wait for others, so it answers `task` or `end` only. See
  /// TaskBoard::claim for which tasks a width gets.
  Claim next(int width);
  /// Returns when the hooks have run.
  void complete(std::int64_t task, const Outcome& outcome);
  /// No task is handed out any more, to any rank. Any rank may call it, more than once.
  void stop();

  struct End {
    bool stopped = false;  ///< somebody called stop()
    TaskBoard board;       ///< as it was left; on rank 0, empty on others
  };
  /// Waits until every rank is here, then ends the service. Nothing may be asked of it afterwards.
  /// @throws  what a hook threw (kinds as in `agree`), on all ranks alike
  /// @note Collective.
  End finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// How a run ended. The counts are the same on every rank.
struct RunReport {
  bool interrupted = false;  ///< a signal left tasks open
  std::int64_t done = 0;     ///< by this run or marked so before it
  std::int64_t failed = 0;
  std::int64_t skipped = 0;
  std::int64_t open = 0;       ///< not begun; more than none only after an interrupt
  double busy_seconds = 0;     ///< of this rank: in tasks, waiting for others of its group included
  double idle_seconds = 0;     ///< of this rank: asking for tasks, waiting for other groups
  std::int64_t tasks_run = 0;  ///< that this rank took part in
  TaskBoard board;             ///< what became of every task; on rank 0, empty on others
};

/// What a task does, called on every rank of its group.
/// @param task   index on the board
/// @param group  communicator of the group; its rank 0 is the leader
/// @return the line of JSON for the journal; the leader's is used
using Work = std::function<std::string(std::int64_t task, MPI_Comm group)>;

/// Runs tasks until none is left: groups of `group_width` ranks first while tasks of that width
/// exist, then single ranks.
///
/// A task that wants more than one rank gets a group of `group_width` ranks, or of the whole world
/// where that is smaller. Groups are neighbours in world; ranks that are left over begin as single
/// ones. What `work` throws on any rank of the group, std::bad_alloc included, becomes a failed
/// outcome on all of them whose record is to_record() of the failure (mpi/failure.hpp). `work`
/// itself must not leave the others of its group waiting: it ends each stage that can fail on one
/// rank with `agree`.
///
/// While an InterruptGuard (mpi/interrupt.hpp) lives, a signal on any rank ends the run: tasks
/// that run are finished, no others begin, and the report says `interrupted`.
///
/// @param board        rank 0's is used
/// @param hooks        rank 0's are called
/// @param group_width  the same on every rank, at least 1
/// @throws core::Error  group_width is below 1
/// @throws  what a hook threw (kinds as in `agree`), on all ranks alike, after running tasks ended
/// @note Collective on world.
RunReport run_tasks(MPI_Comm world, TaskBoard board, ServiceHooks hooks, int group_width,
                    const Work& work);

}  // namespace carillon::mpi
