#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <queue>
#include <string>
#include <vector>

namespace carillon::mpi {

/// A piece of work that a group of ranks does alone.
struct Task {
  std::string key{};                  ///< stable name, unique; the journal knows the task by this
  double cost = 0;                    ///< estimated seconds on one rank
  double memory = 0;                  ///< estimated peak [byte]
  int width = 1;                      ///< ranks of the group it wants
  std::vector<std::int64_t> after{};  ///< indices of tasks that must be done before
};

enum class TaskState { waiting, running, done, failed, skipped };

/// What a finished task reports.
struct Outcome {
  bool ok = true;
  /// One line of JSON for the journal. Of a failed task: {"kind", "message"} and perhaps "hint"
  /// (mpi/failure.hpp).
  std::string record{};
};

/// Answer to a claim.
struct Claim {
  enum class Kind { task, wait, end } kind = Kind::end;
  std::int64_t task = -1;
};

/// Who does what: hands out the dearest ready task of a width, keeps the order of dependencies,
/// marks everything that depends on a failure as skipped. Knows neither MPI nor files. Equal costs
/// go in the order of the list. A claim costs O(log n), a completion that for each dependent task.
class TaskBoard {
 public:
  /// A task may wait only for tasks of its own width or wider: groups do their tasks first and
  /// then fall apart, so that nobody would be left to do a narrower one for them.
  /// @throws core::Error  naming the task: a key that is used twice, a width below 1, a cost or
  ///                      memory that is negative or not finite, a dependency that does not exist,
  ///                      is narrower, or waits for the task itself
  explicit TaskBoard(std::vector<Task> tasks = {});

  /// Before any claim: tasks that want more than one rank get groups of exactly `group_width`.
  void set_group_width(int group_width);
  /// Before any claim: done by an earlier run, whatever became of what it depends on.
  void mark_done(std::int64_t task);
  /// Before any claim: given up by an earlier run (quarantine); what depends on it and is not
  /// done is skipped. Mark all done tasks first.
  void mark_failed(std::int64_t task);

  /// The next task for a group of `width` ranks, which takes tasks of exactly that width: `wait`
  /// while such tasks wait for others, `end` when all of them have been handed out or settled. A
  /// group goes on as narrower groups, at last as single ranks of width 1, when it sees the end.
  Claim claim(int width);
  /// @throws core::Error  the task is not running
  void complete(std::int64_t task, bool ok);

  const std::vector<Task>& tasks() const { return tasks_; }
  TaskState state(std::int64_t task) const;
  std::int64_t count(TaskState state) const;
  /// Estimated seconds of all tasks, and of those done, failed or skipped.
  double total_cost() const { return total_cost_; }
  double settled_cost() const { return settled_cost_; }

 private:
  struct Ready {
    double cost;
    std::int64_t task;
    /// Lesser means later: cheaper, or of equal cost and further down the list.
    bool operator<(const Ready& other) const {
      return cost != other.cost ? cost < other.cost : task > other.task;
    }
  };
  /// Tasks of one width.
  struct Queue {
    std::priority_queue<Ready> ready;  ///< may hold tasks that were marked done since
    std::int64_t waiting = 0;          ///< neither handed out nor settled, ready or not
  };

  std::size_t checked(std::int64_t task) const;
  std::size_t markable(std::int64_t task) const;
  void check_dependencies() const;
  void check_order() const;
  void fill_queues();
  void set_state(std::size_t task, TaskState state);
  void release_dependents(std::size_t task);
  void skip_dependents(std::size_t task);

  std::vector<Task> tasks_;
  std::vector<TaskState> states_;
  std::vector<std::int64_t> unmet_;  ///< for each task, its dependencies that are not done
  std::vector<std::vector<std::size_t>> dependents_;
  std::map<int, Queue> queues_;  ///< by width
  std::array<std::int64_t, 5> counts_{};
  double total_cost_ = 0;
  double settled_cost_ = 0;
  bool claimed_ = false;
};

}  // namespace carillon::mpi
