#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace carillon::mpi {

/// A piece of work that a group of ranks does alone.
struct Task {
  std::string key;                  ///< stable name; the journal knows it by this
  double cost = 0;                  ///< estimated seconds on one rank
  double memory = 0;                ///< estimated peak [byte]
  int width = 1;                    ///< ranks of the group it wants
  std::vector<std::int64_t> after;  ///< indices of tasks that must be done before
};

enum class TaskState { waiting, running, done, failed, skipped };

/// What a finished task reports.
struct Outcome {
  bool ok = true;
  std::string record;  ///< one line of JSON for the journal
};

/// Answer to a claim.
struct Claim {
  enum class Kind { task, wait, end } kind = Kind::end;
  std::int64_t task = -1;
};

/// Who does what: hands out the dearest ready task that fits a group's width, keeps the order of
/// dependencies, marks what depends on a failure as skipped. Knows neither MPI nor files.
class TaskBoard {
 public:
  explicit TaskBoard(std::vector<Task> tasks);

  /// Before any claim: done by an earlier run.
  void mark_done(std::int64_t task);
  Claim claim(int width);
  void complete(std::int64_t task, bool ok);

  const std::vector<Task>& tasks() const { return tasks_; }
  TaskState state(std::int64_t task) const;
  /// Estimated seconds of all tasks, and of those done, failed or skipped.
  double total_cost() const;
  double settled_cost() const;
  std::int64_t count(TaskState state) const;

 private:
  std::vector<Task> tasks_;
  std::vector<TaskState> states_;
  std::vector<std::int64_t> by_cost_;
};

}  // namespace carillon::mpi
