#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "mpi/machine.hpp"
#include "mpi/ready_tasks.hpp"

namespace carillon::mpi {

/// A piece of work that a group of ranks does alone.
struct Task {
  std::string key{};                   ///< stable name, unique; the journal knows the task by this
  double cost = 0;                     ///< estimated seconds on one rank
  double memory = 0;                   ///< estimated peak, all ranks of its group together [byte]
  int width = 1;                       ///< ranks of the group it wants
  std::vector<std::int64_t> after{};   ///< indices of tasks that must be done before
  std::string kind{};                  ///< tasks of a kind have estimates that err alike
  std::vector<std::int64_t> behind{};  ///< tasks that must have ended before, well or not
  bool alone = false;                  ///< nothing else may run beside it
};

enum class TaskState { waiting, running, done, failed, skipped };

/// Where and when a task ran, and what it took.
struct TaskTimes {
  double start = 0;    ///< [s] since the run began
  double seconds = 0;  ///< by the clock on the wall
  double cpu = 0;      ///< [s] of processors (WorkClock::cpu), all ranks of the group
  double queued = 0;   ///< [s] likewise, ready to compute while others had the processors
  int rank = 0;        ///< the group's first
  int width = 1;       ///< ranks of the group
};

/// What a finished task reports.
struct Outcome {
  bool ok = true;
  /// One line of JSON for the journal. Of a failed task: {"kind", "message"} and perhaps "hint"
  /// (mpi/failure.hpp).
  std::string record{};
  TaskTimes times{};
};

/// Answer to a claim.
struct Claim {
  enum class Kind { task, wait, end } kind = Kind::end;
  std::int64_t task = -1;
  bool for_memory = false;  ///< it has to wait though a task of its width is ready
};

/// Who does what: hands out the dearest ready task of a width that the memory of its nodes still
/// holds, keeps the order of dependencies, marks everything that depends on a failure as skipped.
/// Knows neither MPI nor files. Equal costs go in the order of the list. A claim costs O(log n),
/// whether its task is found or memory is short, a completion O(log n) for each dependent task.
class TaskBoard {
 public:
  /// A task may wait only for tasks of its own width or wider: groups do their tasks first and
  /// then fall apart, so that nobody would be left to do a narrower one for them.
  /// @throws core::Error  naming the task: a key that is used twice, a width below 1, a cost or
  ///                      memory that is negative or not finite, a dependency that does not exist,
  ///                      is narrower, or waits for the task itself
  explicit TaskBoard(std::vector<Task> tasks = {});

  /// Before any claim: so many ranks there are, and so much memory. A task that wants more ranks
  /// gets all of them.
  void set_ranks(int ranks, const Machine& machine = {});
  /// Waiting tasks whose estimated memory no group of their width has, even with its nodes to
  /// itself. To be marked failed before any claim: they would be waited for in vain.
  std::vector<std::int64_t> fit_nowhere() const;
  /// Widths of tasks that are not settled, descending.
  std::vector<int> widths() const;
  /// From now on, estimated seconds of a kind count times a factor: in the order of claims and in
  /// the sums of costs.
  void set_factor(const std::string& kind, double factor);
  /// Before any claim: done by an earlier run, whatever became of what it depends on.
  void mark_done(std::int64_t task);
  /// Given up before it began, by an earlier run (quarantine) or with another task; what depends on
  /// it and is not done is skipped. Before any claim, mark all done tasks first.
  /// @throws core::Error  it is done or running
  void mark_failed(std::int64_t task);

  /// The next task for the group of ranks [first, first + width), which takes tasks of exactly that
  /// width: `wait` while such tasks wait for others or for memory, `end` when all of them have been
  /// handed out or settled, or are too large for the nodes of this group. A group goes on as
  /// narrower groups, at last as single ranks of width 1, when it sees the end.
  ///
  /// A task that finds no memory is passed over, so that no rank waits while there is something it
  /// can do; it comes when enough of the others have ended. A task that is to run alone comes when
  /// no other of its width is ready and nothing runs; narrower ones wait until it has ended.
  Claim claim(int width, int first = 0);
  /// @throws core::Error  the task is not running
  void complete(std::int64_t task, bool ok);

  const std::vector<Task>& tasks() const { return tasks_; }
  TaskState state(std::int64_t task) const;
  std::int64_t count(TaskState state) const;
  /// Estimated seconds of all tasks, and of those done, failed or skipped.
  double total_cost() const { return sum_of(&Kind::total); }
  double settled_cost() const { return sum_of(&Kind::settled); }
  const MemoryLedger& memory() const { return ledger_; }

 private:
  struct Kind {
    double factor = 1;
    double total = 0, settled = 0;  ///< sums of costs without the factor
  };
  /// Tasks of one width and kind.
  struct Line {
    std::vector<std::size_t> order;  ///< the dearest first, of equal cost as in the list
    ReadyTasks ready;                ///< by their places in `order`
  };
  /// Tasks of one width.
  struct Queue {
    std::map<std::size_t, Line> lines;  ///< by kind
    std::multiset<double> waiting;      ///< memory of those neither handed out nor settled
    std::set<std::size_t> alone;        ///< of those, what is to run alone: in no line
  };

  std::size_t checked(std::int64_t task) const;
  void check_dependencies() const;
  void check_order() const;
  void number_kinds();
  void fill_queues();
  void make_ready(std::size_t task);
  bool waits_for_one_alone(int width) const;
  std::int64_t next_alone(const Queue& queue, int width, int first) const;
  Line& line_of(std::size_t task) { return queues_[tasks_[task].width].lines[kind_of_[task]]; }
  double sum_of(double Kind::*part) const;
  void set_state(std::size_t task, TaskState state);
  void release(std::size_t task);
  void release_dependents(std::size_t task);
  void skip_dependents(std::size_t task);

  std::vector<Task> tasks_;
  std::vector<TaskState> states_;
  std::vector<std::int64_t> unmet_;  ///< for each task, what it waits for
  std::vector<std::vector<std::size_t>> dependents_;
  std::vector<std::vector<std::size_t>> followers_;  ///< those behind each task
  std::vector<std::size_t> kind_of_;                 ///< for each task, its place in kinds_
  std::map<std::string, std::size_t> kind_numbers_;
  std::vector<Kind> kinds_;
  std::map<int, Queue> queues_;           ///< by width
  std::vector<std::size_t> places_;       ///< for each task, in its line
  std::map<std::int64_t, int> first_of_;  ///< of running tasks, their group's first rank
  MemoryLedger ledger_;
  int ranks_ = 0;  ///< 0: not told
  std::array<std::int64_t, 5> counts_{};
  bool claimed_ = false;
  bool one_runs_alone_ = false;
};

}  // namespace carillon::mpi
