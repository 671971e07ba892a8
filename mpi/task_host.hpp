#pragma once

#include <exception>
#include <functional>
#include <mutex>

#include "mpi/calibration.hpp"
#include "mpi/task_board.hpp"

namespace carillon::mpi {

/// What the host rank does when something happens on the board. One call at a time, from the
/// service's thread or, for the host's own tasks, from the host's thread. An exception stops the
/// run: nobody gets a new task, and it is thrown on every rank at the end.
struct ServiceHooks {
  /// A task ended; `outcome.record` goes to the journal here. The task counts as done (others may
  /// begin what depends on it) only after this has returned.
  std::function<void(const Task&, const Outcome&)> completed{};
  /// Other tasks that a failure concerns as much: those of them that have not begun end with the
  /// same outcome, `completed` is told.
  std::function<std::vector<std::int64_t>(const Task&)> lost_with{};
  /// After every claim that handed out a task, and every completion.
  std::function<void(const TaskBoard&)> progress{};
};

/// The board with its hooks, for several threads. Knows no MPI. Estimates of the board follow what
/// tasks took, kind by kind.
class TaskHost {
 public:
  /// Tasks that fit nowhere (TaskBoard::fit_nowhere) end at once as failures of kind LimitError,
  /// and the hooks are told.
  TaskHost(TaskBoard board, ServiceHooks hooks);

  /// As TaskBoard::claim; `end` once stopped.
  Claim claim(int width, int first = 0);
  void complete(std::int64_t task, const Outcome& outcome);
  /// No task is handed out any more.
  void stop();

  bool stopped() const;
  /// The first exception that a hook threw, or null.
  std::exception_ptr error() const;
  /// The board as it is now.
  TaskBoard board() const;
  Calibration calibration() const;

 private:
  template <class Act>
  void guarded(Act&& act);
  void refuse_what_fits_nowhere();
  void end_with(const Task& failed, const Outcome& outcome);

  mutable std::mutex mutex_;
  TaskBoard board_;
  Calibration calibration_;
  ServiceHooks hooks_;
  bool stopped_ = false;
  std::exception_ptr error_;
};

}  // namespace carillon::mpi
