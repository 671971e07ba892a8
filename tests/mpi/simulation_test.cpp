// Simulated schedules against closed forms, bounds of scheduling theory and exhaustive search.
#include "mpi/simulation.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/error.hpp"
#include "tests/mpi/busy.hpp"

namespace carillon::mpi {
namespace {

/// Tasks whose estimates are right.
std::vector<Task> tasks_of(const std::vector<double>& seconds) {
  std::vector<Task> tasks;
  for (std::size_t i = 0; i < seconds.size(); ++i) {
    tasks.push_back({.key = std::to_string(i), .cost = seconds[i]});
  }
  return tasks;
}

Schedule independent(const std::vector<double>& seconds, int ranks) {
  return simulate(TaskBoard(tasks_of(seconds)), seconds, {.ranks = ranks});
}

TEST(Simulation, EqualTasks) {
  for (const int n : {1, 7, 64, 1000}) {
    for (const int ranks : {1, 2, 7, 64, 5000}) {
      const Schedule schedule = independent(std::vector<double>(n, 3), ranks);
      EXPECT_DOUBLE_EQ(schedule.makespan, 3 * std::ceil(double(n) / ranks)) << n << " " << ranks;
      EXPECT_DOUBLE_EQ(schedule.task_time, 3.0 * n);
      EXPECT_DOUBLE_EQ(schedule.efficiency, 3.0 * n / (ranks * schedule.makespan));
      EXPECT_DOUBLE_EQ(schedule.longest_chain, 3);
    }
  }
}

TEST(Simulation, OneLongTaskIsTheStraggler) {
  std::vector<double> seconds(30, 1);
  seconds[11] = 50;
  const Schedule schedule = independent(seconds, 4);
  EXPECT_DOUBLE_EQ(schedule.makespan, 50);
  EXPECT_EQ(schedule.last_task, 11);
  // The other three share 29 tasks: the first of them finds nothing after 9 s, the last after 10.
  EXPECT_DOUBLE_EQ(schedule.all_at_work_until, 9);
  EXPECT_DOUBLE_EQ(schedule.half_at_work_until, 10);
  EXPECT_DOUBLE_EQ(schedule.idle, 4 * 50 - 79);
}

TEST(Simulation, NoTasks) {
  const Schedule schedule = simulate(TaskBoard(), {}, {.ranks = 3});
  EXPECT_EQ(schedule.makespan, 0);
  EXPECT_EQ(schedule.efficiency, 1);
  EXPECT_EQ(schedule.last_task, -1);
}

TEST(Simulation, ChainsAreNoShorterOnMoreRanks) {
  // Three chains of 10 tasks.
  std::vector<double> seconds(30, 2);
  std::vector<Task> tasks = tasks_of(seconds);
  for (std::int64_t i = 3; i < 30; ++i) tasks[static_cast<std::size_t>(i)].after = {i - 3};
  const std::vector<std::pair<int, double>> cases{{1, 60.0}, {3, 20.0}, {8, 20.0}};
  for (const auto& [ranks, makespan] : cases) {
    const Schedule schedule = simulate(TaskBoard(tasks), seconds, {.ranks = ranks});
    EXPECT_DOUBLE_EQ(schedule.makespan, makespan) << ranks;
    EXPECT_DOUBLE_EQ(schedule.longest_chain, 20);
  }
  // Five ranks too many waited all the time.
  const Schedule schedule = simulate(TaskBoard(tasks), seconds, {.ranks = 8});
  EXPECT_DOUBLE_EQ(schedule.half_at_work_until, 0);
  EXPECT_DOUBLE_EQ(schedule.idle, 5 * 20);
}

TEST(Simulation, WaitingRanksFindWhatACompletionSetsFree) {
  // One task of 10 s, then 4 of 1 s that wait for it.
  std::vector<double> seconds{10, 1, 1, 1, 1};
  std::vector<Task> tasks = tasks_of(seconds);
  for (std::size_t i = 1; i < 5; ++i) tasks[i].after = {0};
  EXPECT_DOUBLE_EQ(simulate(TaskBoard(tasks), seconds, {.ranks = 4}).makespan, 11);
}

TEST(Simulation, GroupsComeFirstAndFallApart) {
  // 7 ranks in groups of 3: two groups take 4 wide tasks of 5 s while one rank begins alone.
  std::vector<double> seconds{5, 5, 5, 5, 10, 4, 4, 4, 4, 4, 4};
  std::vector<Task> tasks = tasks_of(seconds);
  for (std::size_t i = 0; i < 4; ++i) tasks[i].width = 3;
  const Schedule schedule = simulate(TaskBoard(tasks), seconds, {.ranks = 7});
  EXPECT_DOUBLE_EQ(schedule.makespan, 14);
  EXPECT_DOUBLE_EQ(schedule.task_time, 3 * 4 * 5 + 10 + 6 * 4);
}

TEST(Simulation, GroupsOfSeveralWidthsFormAsRanksComeFree) {
  // One task for 4 of 6 ranks, two for 2, then single ones: ranks 4 and 5 begin as a pair.
  const std::vector<double> seconds{6, 5, 2, 1, 1, 1, 1, 1, 1};
  std::vector<Task> tasks = tasks_of(seconds);
  tasks[0].width = 4;
  tasks[1].width = tasks[2].width = 2;
  const Schedule schedule = simulate(TaskBoard(tasks), seconds, {.ranks = 6});
  // The pair takes 5 s, then 2 s; the four come free after 6 s and take four of the single tasks
  // until 7 s, then two more beside those of the pair.
  EXPECT_DOUBLE_EQ(schedule.makespan, 8);
  EXPECT_DOUBLE_EQ(schedule.task_time, 24 + 10 + 4 + 6);
}

TEST(Simulation, TasksWaitForTheMemoryOfTheirNode) {
  // 4 ranks on 2 nodes of 10 bytes: tasks of 6 bytes run one at a time on each.
  const std::vector<double> seconds(6, 1);
  std::vector<Task> tasks = tasks_of(seconds);
  for (Task& task : tasks) task.memory = 6;
  SimulatedRanks on{.ranks = 4, .ranks_per_node = 2, .node_memory = 10};
  const Schedule bounded = simulate(TaskBoard(tasks), seconds, on);
  EXPECT_DOUBLE_EQ(bounded.makespan, 3);
  EXPECT_DOUBLE_EQ(bounded.node_memory, 6);
  // Two ranks wait for 2 s, then the last two tasks are under way and there is nothing to wait for.
  EXPECT_DOUBLE_EQ(bounded.memory_wait, 4);
  EXPECT_DOUBLE_EQ(bounded.idle, 6);
  on.node_memory = 12;
  EXPECT_DOUBLE_EQ(simulate(TaskBoard(tasks), seconds, on).makespan, 2);
  EXPECT_EQ(simulate(TaskBoard(tasks), seconds, on).memory_wait, 0);
  // Nobody has 5 bytes for a task of 6; what waits for it is not run either.
  tasks[5].after = {0};
  on.node_memory = 5;
  for (std::size_t i = 1; i < 6; ++i) tasks[i].memory = 1;
  const Schedule refused = simulate(TaskBoard(tasks), seconds, on);
  EXPECT_EQ(refused.refused, 2);
  EXPECT_DOUBLE_EQ(refused.makespan, 1);
}

TEST(Simulation, EstimatesAreCorrectedAsTasksEnd) {
  // Kind a is ten times as long as estimated: seen after three of its tasks, the rest of it goes
  // before kind b, and nothing long is left for the end.
  std::vector<Task> tasks;
  std::vector<double> seconds;
  for (int i = 0; i < 38; ++i) {
    const bool a = i < 8;
    tasks.push_back({.key = std::to_string(i), .cost = a ? 1.0 : 3.5, .kind = a ? "a" : "b"});
    seconds.push_back(a ? 10 : 3.5);
  }
  tasks[0].cost = tasks[1].cost = tasks[2].cost = 4;  // these come first
  seconds[0] = seconds[1] = seconds[2] = 40;
  const Schedule schedule = simulate(TaskBoard(tasks), seconds, {.ranks = 2});
  for (Task& task : tasks) task.kind = "";
  const Schedule blind = simulate(TaskBoard(tasks), seconds, {.ranks = 2});
  EXPECT_LT(schedule.makespan, blind.makespan);
}

TEST(Simulation, MemoryOfANodeIsThatOfItsRanks) {
  std::vector<double> seconds(6, 1);
  std::vector<Task> tasks = tasks_of(seconds);
  for (Task& task : tasks) task.memory = 10;
  const auto memory = [&](int ranks, int per_node) {
    return simulate(TaskBoard(tasks), seconds, {.ranks = ranks, .ranks_per_node = per_node})
        .node_memory;
  };
  EXPECT_DOUBLE_EQ(memory(1, 8), 10);
  EXPECT_DOUBLE_EQ(memory(6, 1), 10);
  EXPECT_DOUBLE_EQ(memory(6, 4), 40);
  EXPECT_DOUBLE_EQ(memory(64, 64), 60);
}

TEST(Simulation, WhatIsDoneCostsNothing) {
  const std::vector<double> seconds{5, 7, 1};
  TaskBoard board(tasks_of(seconds));
  board.mark_done(1);
  EXPECT_DOUBLE_EQ(simulate(std::move(board), seconds, {.ranks = 2}).makespan, 5);
}

TEST(Simulation, RefusesWhatCannotBe) {
  const std::vector<double> one{1}, bad{std::numeric_limits<double>::quiet_NaN()};
  const TaskBoard board(tasks_of(one));
  EXPECT_THROW(simulate(board, one, {.ranks = 0}), core::Error);
  EXPECT_THROW(simulate(board, one, {.ranks = 1, .ranks_per_node = 0}), core::Error);
  EXPECT_THROW(simulate(board, {}, {.ranks = 1}), core::Error);
  EXPECT_THROW(simulate(board, bad, {.ranks = 1}), core::Error);
}

/// Shortest makespan of all ways to share tasks among ranks.
double best_makespan(const std::vector<double>& seconds, std::vector<double>& load,
                     std::size_t task = 0) {
  if (task == seconds.size()) return *std::max_element(load.begin(), load.end());
  double best = std::numeric_limits<double>::infinity();
  for (double& one : load) {
    one += seconds[task];
    best = std::min(best, best_makespan(seconds, load, task + 1));
    one -= seconds[task];
  }
  return best;
}

TEST(Simulation, LongestFirstIsNoWorseThanGrahamsBound) {
  EXPECT_TRUE(rc::check("at most 4/3 - 1/(3 m) of the best schedule (Graham 1969)", [] {
    const int ranks = *rc::gen::inRange(1, 4);
    const auto n = *rc::gen::inRange<std::size_t>(1, 9);
    std::vector<double> seconds(n);
    for (double& one : seconds) one = *rc::gen::inRange(0, 20);
    std::vector<double> load(static_cast<std::size_t>(ranks), 0);
    const double best = best_makespan(seconds, load);
    const double made = independent(seconds, ranks).makespan;
    RC_ASSERT(made >= best);
    RC_ASSERT(made <= (4.0 / 3 - 1.0 / (3 * ranks)) * best + 1e-12);
  }));
}

TEST(Simulation, GrahamsWorstCaseIsMet) {
  // 2m - 1, 2m - 1, 2m - 2, ..., m + 1, m + 1, m, m, m on m ranks: 4m - 1 instead of 3m.
  for (const int m : {2, 3, 8}) {
    std::vector<double> seconds;
    for (int length = 2 * m - 1; length > m; --length) {
      seconds.insert(seconds.end(), 2, length);
    }
    seconds.insert(seconds.end(), 3, m);
    EXPECT_DOUBLE_EQ(independent(seconds, m).makespan, 4 * m - 1) << m;
  }
}

TEST(Simulation, AnyListIsNoWorseThanTheTwoBoundsTogether) {
  EXPECT_TRUE(
      rc::check("work shared by all ranks, and the longest chain, bound from both sides", [] {
        const int ranks = *rc::gen::inRange(1, 9);
        const auto n = *rc::gen::inRange<std::size_t>(1, 40);
        std::vector<double> seconds(n);
        for (double& one : seconds) one = *rc::gen::inRange(0, 20);
        std::vector<Task> tasks = tasks_of(seconds);
        for (std::size_t i = 1; i < n; ++i) {
          tasks[i].cost = *rc::gen::inRange(0, 9);  // estimates may be wrong
          if (*rc::gen::inRange(0, 2) == 0) {
            tasks[i].after = {static_cast<std::int64_t>(*rc::gen::inRange<std::size_t>(0, i))};
          }
        }
        const Schedule schedule = simulate(TaskBoard(tasks), seconds, {.ranks = ranks});
        const double bound = std::max(schedule.shared_work, schedule.longest_chain);
        RC_ASSERT(schedule.makespan >= bound - 1e-9);
        RC_ASSERT(schedule.makespan <= schedule.shared_work + schedule.longest_chain + 1e-9);
        RC_ASSERT(std::abs(schedule.idle - (ranks * schedule.makespan - schedule.task_time)) <
                  1e-9);
        RC_ASSERT(schedule.all_at_work_until <= schedule.half_at_work_until + 1e-9);
        RC_ASSERT(schedule.half_at_work_until <= schedule.makespan + 1e-9);
      }));
}

TEST(Simulation, AMillionTasksOnThousandsOfRanks) {
  // A queue that is searched from end to end would take hours.
  std::vector<double> seconds(1000000);
  for (std::size_t i = 0; i < seconds.size(); ++i) seconds[i] = 1 + static_cast<double>(i % 97);
  TaskBoard board(tasks_of(seconds));
  const double start = processor_seconds();
  const Schedule schedule = simulate(std::move(board), seconds, {.ranks = 4096});
  EXPECT_LT(processor_seconds() - start, 20);
  EXPECT_GT(schedule.efficiency, 0.9);
}

}  // namespace
}  // namespace carillon::mpi
