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

  /// Next task for a group of `width` ranks whose first is this one; called by it alone, the
  /// group's leader. Sleeps while tasks are pending that wait for others or for memory, so it
  /// answers `task` or `end` only. See TaskBoard::claim for which tasks a width gets.
  Claim next(int width);
  /// Returns when the hooks have run.
  void complete(std::int64_t task, const Outcome& outcome);
  /// No task is handed out any more, to any rank. Any rank may call it, more than once.
  void stop();

  struct End {
    bool stopped = false;     ///< somebody called stop()
    TaskBoard board;          ///< as it was left; on rank 0, empty on others
    Calibration calibration;  ///< likewise
  };
  /// Waits until every rank is here, then ends the service. Nothing may be asked of it afterwards.
  /// @throws  what a hook threw (kinds as in `agree`), on all ranks alike
  /// @note Collective.
  End finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// What a rank did with the time of a run [s].
struct RankTimes {
  double busy = 0;         ///< in tasks, waiting for others of its group included
  double idle = 0;         ///< asking for tasks, waiting for other groups
  double cpu = 0;          ///< of processors in tasks, as WorkClock::cpu
  double queued = 0;       ///< ready to compute, in tasks or not, but others had the processor
  double peak_memory = 0;  ///< [byte] most that this process ever held
};

/// How a run ended. The counts are the same on every rank.
struct RunReport {
  bool interrupted = false;  ///< a signal left tasks open
  std::int64_t done = 0;     ///< by this run or marked so before it
  std::int64_t failed = 0;
  std::int64_t skipped = 0;
  std::int64_t open = 0;       ///< not begun; more than none only after an interrupt
  RankTimes times;             ///< of this rank
  std::int64_t tasks_run = 0;  ///< that this rank took part in
  TaskBoard board;             ///< what became of every task; on rank 0, empty on others
  Calibration calibration;     ///< of this run's tasks; on rank 0, empty on others
};

/// What a task does, called on every rank of its group.
/// @param task   index on the board
/// @param group  communicator of the group; its rank 0 is the leader
/// @return the line of JSON for the journal; the leader's is used
using Work = std::function<std::string(std::int64_t task, MPI_Comm group)>;

/// Runs tasks until none is left, the widest first: ranks form groups of the largest width that a
/// task wants, then narrower ones, at last they are single.
///
/// A task gets a group of its width, or of the whole world where that is smaller. Groups are
/// neighbours in world; ranks that are left over begin with the next narrower width. A task begins
/// only when its estimated memory is free on the nodes of its group; one that fits nowhere fails
/// before any begins. What `work` throws on any rank of the group, std::bad_alloc included, becomes
/// a failed outcome on all of them whose record is to_record() of the failure (mpi/failure.hpp).
/// `work` itself must not leave the others of its group waiting: it ends each stage that can fail
/// on one rank with `agree`.
///
/// While an InterruptGuard (mpi/interrupt.hpp) lives, a signal on any rank ends the run: tasks
/// that run are finished, no others begin, and the report says `interrupted`.
///
/// @param board    rank 0's is used
/// @param hooks    rank 0's are called
/// @param machine  rank 0's is used; without nodes, memory is not looked at
/// @throws core::Error  the machine is one of another number of ranks
/// @throws  what a hook threw (kinds as in `agree`), on all ranks alike, after running tasks ended
/// @note Collective on world.
RunReport run_tasks(MPI_Comm world, TaskBoard board, ServiceHooks hooks, const Work& work,
                    const Machine& machine = {});

}  // namespace carillon::mpi
