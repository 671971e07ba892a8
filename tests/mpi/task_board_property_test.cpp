// The task board under random lists, random failures and any order of claims and completions.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "mpi/task_board.hpp"

namespace carillon::mpi {
namespace {

struct Plan {
  std::vector<Task> tasks;
  std::vector<bool> fails;
};

/// A list without circles whose dependencies point both up and down the list.
Plan random_plan(int widest) {
  const auto n = *rc::gen::inRange<std::size_t>(0, 30);
  // hidden[p] is the task at place p of a hidden order; dependencies go back in it.
  std::vector<std::size_t> hidden(n);
  std::iota(hidden.begin(), hidden.end(), std::size_t{0});
  for (std::size_t i = n; i > 1; --i) {
    std::swap(hidden[i - 1], hidden[*rc::gen::inRange<std::size_t>(0, i)]);
  }
  Plan plan;
  plan.tasks.resize(n);
  for (std::size_t place = 0; place < n; ++place) {
    Task& task = plan.tasks[hidden[place]];
    task.key = std::to_string(hidden[place]);
    task.cost = *rc::gen::inRange(0, 6);
    task.width = *rc::gen::inRange(1, widest + 1);
    const auto wanted = place == 0 ? 0 : *rc::gen::inRange(0, 4);
    for (int k = 0; k < wanted; ++k) {
      const std::size_t earlier = hidden[*rc::gen::inRange<std::size_t>(0, place)];
      if (plan.tasks[earlier].width >= task.width) {
        task.after.push_back(static_cast<std::int64_t>(earlier));
      }
    }
    task.alone = *rc::gen::inRange(0, 8) == 0;
    plan.fails.push_back(*rc::gen::inRange(0, 5) == 0);
  }
  return plan;
}

/// What the board ought to hand out, by looking at every task.
Claim expected_claim(const TaskBoard& board, int width) {
  Claim best, alone;
  bool any_waiting = false;
  for (std::size_t i = 0; i < board.tasks().size(); ++i) {
    const TaskState state = board.state(static_cast<std::int64_t>(i));
    const Task& task = board.tasks()[i];
    const bool wider = task.width > width && state == TaskState::waiting;
    if (task.alone && (wider || state == TaskState::running)) return {Claim::Kind::wait};
  }
  for (std::size_t i = 0; i < board.tasks().size(); ++i) {
    const Task& task = board.tasks()[i];
    const auto index = static_cast<std::int64_t>(i);
    if (task.width != width || board.state(index) != TaskState::waiting) continue;
    any_waiting = true;
    const bool ready = std::all_of(task.after.begin(), task.after.end(), [&](std::int64_t before) {
      return board.state(before) == TaskState::done;
    });
    if (!ready) continue;
    if (task.alone) {
      if (alone.task < 0) alone = {Claim::Kind::task, index};
      continue;
    }
    if (best.task < 0 || task.cost > board.tasks()[static_cast<std::size_t>(best.task)].cost) {
      best = {Claim::Kind::task, index};
    }
  }
  if (best.task < 0 && board.count(TaskState::running) == 0) best = alone;
  if (best.task < 0 && any_waiting) best.kind = Claim::Kind::wait;
  return best;
}

bool has_failed_ancestor(const TaskBoard& board, std::int64_t task) {
  const std::vector<std::int64_t>& after = board.tasks()[static_cast<std::size_t>(task)].after;
  return std::any_of(after.begin(), after.end(), [&](std::int64_t before) {
    return board.state(before) == TaskState::failed || has_failed_ancestor(board, before);
  });
}

struct Worker {
  int width;
  std::int64_t task = -1;
};

/// Lets workers act in random order until all have seen the end; a worker of a width goes on as
/// one of the next lower width, as groups do.
std::vector<std::int64_t> work_off(TaskBoard& board, const Plan& plan, int widest) {
  std::vector<Worker> workers(*rc::gen::inRange<std::size_t>(1, 5), Worker{widest});
  std::vector<std::int64_t> started;
  // Each step of a worker that is not told to wait makes progress, and while one is told to wait
  // another one is running, so this many steps are far more than enough.
  const std::size_t maximum = 1000 * (plan.tasks.size() + 10);
  for (std::size_t step = 0; step < maximum && !workers.empty(); ++step) {
    const auto chosen = *rc::gen::inRange<std::size_t>(0, workers.size());
    Worker& worker = workers[chosen];
    if (worker.task >= 0) {
      board.complete(worker.task, !plan.fails[static_cast<std::size_t>(worker.task)]);
      worker.task = -1;
      continue;
    }
    const Claim expected = expected_claim(board, worker.width);
    const Claim claim = board.claim(worker.width);
    RC_ASSERT(claim.kind == expected.kind);
    RC_ASSERT(claim.task == expected.task);
    if (claim.kind == Claim::Kind::task) {
      worker.task = claim.task;
      started.push_back(claim.task);
    } else if (claim.kind == Claim::Kind::end && --worker.width == 0) {
      workers.erase(workers.begin() + static_cast<std::ptrdiff_t>(chosen));
    } else if (claim.kind == Claim::Kind::wait) {
      RC_ASSERT(std::any_of(workers.begin(), workers.end(),
                            [](const Worker& other) { return other.task >= 0; }));
    }
  }
  RC_ASSERT(workers.empty());
  return started;
}

TEST(TaskBoardProperty, AnyInterleavingSettlesEveryTaskOnce) {
  const bool holds = rc::check([] {
    const int widest = *rc::gen::inRange(1, 4);
    const Plan plan = random_plan(widest);
    TaskBoard board(plan.tasks);
    const std::vector<std::int64_t> started = work_off(board, plan, widest);

    RC_ASSERT(std::set<std::int64_t>(started.begin(), started.end()).size() == started.size());
    for (std::size_t i = 0; i < plan.tasks.size(); ++i) {
      const auto index = static_cast<std::int64_t>(i);
      const TaskState expected = has_failed_ancestor(board, index) ? TaskState::skipped
                                 : plan.fails[i]                   ? TaskState::failed
                                                                   : TaskState::done;
      RC_ASSERT(board.state(index) == expected);
      const bool was_started = std::find(started.begin(), started.end(), index) != started.end();
      RC_ASSERT(was_started == (expected != TaskState::skipped));
    }
    const auto n = static_cast<std::int64_t>(plan.tasks.size());
    RC_ASSERT(board.count(TaskState::done) + board.count(TaskState::failed) +
                  board.count(TaskState::skipped) ==
              n);
    RC_ASSERT(board.settled_cost() == board.total_cost());
  });
  EXPECT_TRUE(holds);
}

TEST(TaskBoardProperty, ResumedTasksAreNeverStartedAgain) {
  const bool holds = rc::check([] {
    Plan plan = random_plan(1);
    std::fill(plan.fails.begin(), plan.fails.end(), false);
    TaskBoard board(plan.tasks);
    std::set<std::int64_t> resumed;
    for (std::size_t i = 0; i < plan.tasks.size(); ++i) {
      if (*rc::gen::arbitrary<bool>()) resumed.insert(static_cast<std::int64_t>(i));
    }
    for (const std::int64_t task : resumed) board.mark_done(task);
    const std::vector<std::int64_t> started = work_off(board, plan, 1);
    RC_ASSERT(started.size() + resumed.size() == plan.tasks.size());
    for (const std::int64_t task : started) RC_ASSERT(!resumed.contains(task));
    RC_ASSERT(board.count(TaskState::done) == static_cast<std::int64_t>(plan.tasks.size()));
  });
  EXPECT_TRUE(holds);
}

}  // namespace
}  // namespace carillon::mpi
