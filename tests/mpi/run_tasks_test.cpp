#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <map>
#include <new>
#include <nlohmann/json.hpp>
#include <string>

#include "core/error.hpp"
#include "mpi/comm.hpp"
#include "mpi/failure.hpp"
#include "mpi/interrupt.hpp"
#include "mpi/task_service.hpp"
#include "tests/mpi/busy.hpp"

namespace carillon::mpi {
namespace {

const MPI_Comm world = MPI_COMM_WORLD;

TaskBoard on_host(std::vector<Task> tasks) {
  return rank(world) == 0 ? TaskBoard(std::move(tasks)) : TaskBoard();
}

std::vector<Task> singles(int n) {
  std::vector<Task> tasks;
  for (int i = 0; i < n; ++i) tasks.push_back({.key = std::to_string(i)});
  return tasks;
}

/// On rank 0, the outcome of every task by its key.
struct Outcomes {
  std::map<std::string, Outcome> by_key;
  ServiceHooks hooks() {
    return {.completed = [this](const Task& task, const Outcome& outcome) {
      EXPECT_TRUE(by_key.emplace(task.key, outcome).second) << task.key << " ended twice";
    }};
  }
};

std::int64_t sum(std::int64_t value, MPI_Comm comm) {
  std::int64_t total = 0;
  MPI_Allreduce(&value, &total, 1, MPI_INT64_T, MPI_SUM, comm);
  return total;
}

TEST(RunTasks, EveryTaskOnceWithItsRecord) {
  Outcomes outcomes;
  const RunReport report =
      run_tasks(world, on_host(singles(60)), outcomes.hooks(), [](std::int64_t task, MPI_Comm) {
        sleep_for(0.001);
        return nlohmann::json{{"square", task * task}}.dump();
      });
  EXPECT_EQ(report.done, 60);
  EXPECT_EQ(report.failed + report.skipped + report.open, 0);
  EXPECT_FALSE(report.interrupted);
  EXPECT_EQ(sum(report.tasks_run, world), 60);
  if (rank(world) == 0) {
    ASSERT_EQ(outcomes.by_key.size(), 60U);
    EXPECT_EQ(outcomes.by_key.at("7").record, "{\"square\":49}");
  }
}

TEST(RunTasks, ATaskBeginsAfterWhatItWaitsFor) {
  // 10 shapes, each with 3 lots of samples; times of one machine's clock.
  std::vector<Task> tasks = singles(10);
  for (std::int64_t i = 0; i < 30; ++i) {
    tasks.push_back({.key = fmt::format("s{}", i), .cost = 5, .after = {i % 10}});
  }
  std::vector<double> begun(40, 0);
  std::vector<double> ended(40, 0);
  run_tasks(world, on_host(tasks), {}, [&](std::int64_t task, MPI_Comm) {
    begun[static_cast<std::size_t>(task)] = core::monotonic_seconds();
    sleep_for(0.002);
    ended[static_cast<std::size_t>(task)] = core::monotonic_seconds();
    return "{}";
  });
  MPI_Allreduce(MPI_IN_PLACE, begun.data(), 40, MPI_DOUBLE, MPI_MAX, world);
  MPI_Allreduce(MPI_IN_PLACE, ended.data(), 40, MPI_DOUBLE, MPI_MAX, world);
  for (std::size_t i = 10; i < 40; ++i) EXPECT_GT(begun[i], ended[i % 10]);
}

TEST(RunTasks, AFailureIsRecordedAndSkipsWhatDependsOnIt) {
  std::vector<Task> tasks = singles(3);
  tasks.push_back({.key = "after 1", .after = {1}});
  Outcomes outcomes;
  const RunReport report = run_tasks(
      world, on_host(tasks), outcomes.hooks(), [](std::int64_t task, MPI_Comm) -> std::string {
        if (task == 1) throw core::SolverError("no convergence", "more iterations");
        if (task == 2) throw std::bad_alloc();
        return "{}";
      });
  EXPECT_EQ(report.done, 1);
  EXPECT_EQ(report.failed, 2);
  EXPECT_EQ(report.skipped, 1);
  if (rank(world) != 0) return;
  EXPECT_FALSE(outcomes.by_key.at("1").ok);
  EXPECT_EQ(from_record(outcomes.by_key.at("1").record),
            (Failure{"SolverError", "no convergence", "more iterations"}));
  EXPECT_EQ(from_record(outcomes.by_key.at("2").record), (Failure{"MemoryError", "out of memory"}));
  EXPECT_EQ(outcomes.by_key.count("after 1"), 0U);
  EXPECT_EQ(report.board.state(3), TaskState::skipped);
}

/// One rank of a group falls: both know, and the next task runs on both.
TEST(RunTasks, AFailureOnOneRankOfAGroupIsTheGroupsAndTheNextTaskRuns) {
  const int width = std::min(2, size(world));
  std::vector<Task> tasks;
  for (int i = 0; i < 6; ++i) tasks.push_back({.key = std::to_string(i), .width = 2});
  Outcomes outcomes;
  std::vector<int> ran(6, 0);
  const RunReport report =
      run_tasks(world, on_host(tasks), outcomes.hooks(), [&](std::int64_t task, MPI_Comm group) {
        ran[static_cast<std::size_t>(task)] = 1;
        if (task % 2 == 1 && rank(group) == size(group) - 1) {
          throw TaskError({"SolverError", "no convergence", "finer", "solve", "bar/steel/1"});
        }
        return std::string("{}");
      });
  EXPECT_EQ(report.done, 3);
  EXPECT_EQ(report.failed, 3);
  MPI_Allreduce(MPI_IN_PLACE, ran.data(), 6, MPI_INT, MPI_SUM, world);
  EXPECT_EQ(ran, std::vector<int>(6, width));
  if (rank(world) != 0) return;
  for (const char* key : {"1", "3", "5"}) {
    EXPECT_EQ(from_record(outcomes.by_key.at(key).record),
              (Failure{"SolverError", "no convergence", "finer", "solve", "bar/steel/1"}));
  }
  EXPECT_EQ(outcomes.by_key.at("4").record, "{}");
}

class GroupWidth : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(RunTasks, GroupWidth, testing::Values(1, 2, 3, 4, 7));

TEST_P(GroupWidth, WideTasksRunOnGroupsAndNarrowOnesOnSingleRanks) {
  const int width = std::min(GetParam(), size(world));
  std::vector<Task> tasks;
  for (std::int64_t i = 0; i < 5; ++i)
    tasks.push_back({.key = std::to_string(i), .width = GetParam()});
  for (std::int64_t i = 5; i < 25; ++i) {
    tasks.push_back({.key = std::to_string(i), .cost = 9, .after = {i % 5}});
  }
  std::vector<int> members(25, 0);
  std::vector<int> sizes(25, 0);
  Outcomes outcomes;
  const RunReport report =
      run_tasks(world, on_host(tasks), outcomes.hooks(), [&](std::int64_t task, MPI_Comm group) {
        const auto i = static_cast<std::size_t>(task);
        members[i] = static_cast<int>(sum(1, group));
        sizes[i] = size(group);
        return nlohmann::json{{"rank", rank(group)}}.dump();
      });
  EXPECT_EQ(report.done, 25);
  MPI_Allreduce(MPI_IN_PLACE, members.data(), 25, MPI_INT, MPI_SUM, world);
  MPI_Allreduce(MPI_IN_PLACE, sizes.data(), 25, MPI_INT, MPI_MAX, world);
  for (std::size_t i = 0; i < 25; ++i) {
    const int expected = i < 5 ? width : 1;
    EXPECT_EQ(sizes[i], expected);
    EXPECT_EQ(members[i], expected * expected);  // each of the group's ranks counted the group
  }
  EXPECT_EQ(sum(report.tasks_run, world), 5 * width + 20);
  if (rank(world) == 0) {
    EXPECT_EQ(outcomes.by_key.at("3").record, "{\"rank\":0}");
  }
}

TEST_P(GroupWidth, AFailureOnOneRankOfAGroupIsTheGroups) {
  const int width = std::min(GetParam(), size(world));
  std::vector<Task> tasks;
  for (int i = 0; i < 12; ++i) tasks.push_back({.key = std::to_string(i), .width = GetParam()});
  tasks.push_back({.key = "after 0", .after = {0}});
  tasks.push_back({.key = "after 1", .after = {1}});
  Outcomes outcomes;
  const RunReport report =
      run_tasks(world, on_host(tasks), outcomes.hooks(),
                [&](std::int64_t task, MPI_Comm group) -> std::string {
                  // A different rank of the group each time; only every second task fails.
                  if (task < 12 && task % 2 == 0 && rank(group) == task / 2 % width) {
                    throw core::InputError(fmt::format("task {}", task));
                  }
                  return "{}";
                });
  EXPECT_EQ(report.failed, 6);
  EXPECT_EQ(report.done, 7);
  EXPECT_EQ(report.skipped, 1);
  if (rank(world) != 0) return;
  for (int i = 0; i < 12; i += 2) {
    EXPECT_EQ(from_record(outcomes.by_key.at(std::to_string(i)).record),
              (Failure{"InputError", fmt::format("task {}", i), ""}));
  }
}

TEST(RunTasks, AnExceptionInAHookIsThrownOnEveryRank) {
  int completed = 0;
  const ServiceHooks hooks{.completed = [&](const Task&, const Outcome&) {
    if (++completed == 3) throw core::FileError("journal.jsonl: cannot be written");
  }};
  std::vector<Task> tasks = singles(40);
  for (int i = 0; i < 6; ++i) tasks.push_back({.key = fmt::format("w{}", i), .width = 2});
  EXPECT_THROW(run_tasks(world, on_host(tasks), hooks, [](std::int64_t, MPI_Comm) { return "{}"; }),
               core::FileError);
}

TEST(RunTasks, WavesOfGroupsFromWideToNarrow) {
  const std::vector<int> widths{4, 2, 2, 3, 1, 1, 1, 1, 2};
  std::vector<Task> tasks;
  for (std::size_t i = 0; i < widths.size(); ++i) {
    tasks.push_back({.key = std::to_string(i), .cost = 1, .width = widths[i]});
  }
  std::vector<int> sizes(widths.size(), 0);
  std::vector<int> last_width;  // what this rank did, in order
  Outcomes outcomes;
  run_tasks(world, on_host(tasks), outcomes.hooks(), [&](std::int64_t task, MPI_Comm group) {
    sizes[static_cast<std::size_t>(task)] = size(group);
    last_width.push_back(size(group));
    MPI_Barrier(group);
    return "{}";
  });
  MPI_Allreduce(MPI_IN_PLACE, sizes.data(), static_cast<int>(sizes.size()), MPI_INT, MPI_MAX,
                world);
  for (std::size_t i = 0; i < widths.size(); ++i) {
    EXPECT_EQ(sizes[i], std::min(widths[i], size(world)));
  }
  EXPECT_TRUE(std::is_sorted(last_width.rbegin(), last_width.rend()));
  if (rank(world) != 0) return;
  for (const auto& [key, outcome] : outcomes.by_key) {
    EXPECT_EQ(outcome.times.width, sizes[static_cast<std::size_t>(std::stoi(key))]);
    EXPECT_EQ(outcome.times.rank % outcome.times.width, 0);
    EXPECT_GE(outcome.times.start, 0);
  }
}

TEST(RunTasks, NoMoreAtOnceThanTheNodeHolds) {
  // Tasks of 1, on a node that holds two of them at a time.
  Machine machine{std::vector<int>(static_cast<std::size_t>(size(world)), 0), {2}};
  std::vector<Task> tasks = singles(24);
  for (Task& task : tasks) task.memory = 1;
  std::vector<double> begun(24, 0), ended(24, 0);
  const RunReport report = run_tasks(
      world, on_host(tasks), {},
      [&](std::int64_t task, MPI_Comm) {
        begun[static_cast<std::size_t>(task)] = core::monotonic_seconds();
        sleep_for(0.005);
        ended[static_cast<std::size_t>(task)] = core::monotonic_seconds();
        return "{}";
      },
      machine);
  EXPECT_EQ(report.done, 24);
  MPI_Allreduce(MPI_IN_PLACE, begun.data(), 24, MPI_DOUBLE, MPI_MAX, world);
  MPI_Allreduce(MPI_IN_PLACE, ended.data(), 24, MPI_DOUBLE, MPI_MAX, world);
  for (std::size_t i = 0; i < 24; ++i) {
    int together = 0;
    for (std::size_t j = 0; j < 24; ++j) {
      if (begun[j] <= begun[i] && begun[i] < ended[j]) ++together;
    }
    EXPECT_LE(together, 2);
  }
}

TEST(RunTasks, ATaskThatFitsNowhereFailsWithItsReason) {
  const int n = size(world);
  Machine machine{std::vector<int>(static_cast<std::size_t>(n), 0), {1 << 30}};
  std::vector<Task> tasks = singles(3);
  tasks[1].memory = 3e9;
  tasks[2].after = {1};
  Outcomes outcomes;
  const RunReport report = run_tasks(
      world, on_host(tasks), outcomes.hooks(), [](std::int64_t, MPI_Comm) { return "{}"; },
      machine);
  EXPECT_EQ(report.done, 1);
  EXPECT_EQ(report.failed, 1);
  EXPECT_EQ(report.skipped, 1);
  if (rank(world) != 0) return;
  const Failure failure = from_record(outcomes.by_key.at("1").record);
  EXPECT_EQ(failure.kind, "LimitError");
  EXPECT_NE(failure.message.find("the largest has 1.0 GiB"), std::string::npos) << failure.message;
  EXPECT_TRUE(failure.lasting);
}

TEST(RunTasks, WhatIsMeasuredIsTheFailureOfThisRunAlone) {
  Machine machine{std::vector<int>(static_cast<std::size_t>(size(world)), 0), {1 << 30}, true};
  std::vector<Task> tasks = singles(1);
  tasks[0].memory = 3e9;
  Outcomes outcomes;
  run_tasks(
      world, on_host(tasks), outcomes.hooks(), [](std::int64_t, MPI_Comm) { return "{}"; },
      machine);
  if (rank(world) != 0) return;
  const Failure failure = from_record(outcomes.by_key.at("0").record);
  EXPECT_FALSE(failure.lasting);
  EXPECT_NE(failure.hint.find("the same command tries again"), std::string::npos) << failure.hint;
}

TEST(RunTasks, TimesTellWorkFromRest) {
  std::vector<Task> tasks = singles(2);
  for (Task& task : tasks) task = {.key = task.key, .cost = 0.1, .kind = "a"};
  Outcomes outcomes;
  const RunReport report =
      run_tasks(world, on_host(tasks), outcomes.hooks(), [](std::int64_t task, MPI_Comm) {
        const double start = processor_seconds();
        while (task == 0 && processor_seconds() - start < 0.1) {
        }
        if (task == 1) sleep_for(0.1);
        return "{}";
      });
  double cpu = report.times.cpu;
  MPI_Allreduce(MPI_IN_PLACE, &cpu, 1, MPI_DOUBLE, MPI_SUM, world);
  EXPECT_NEAR(cpu, 0.1, 0.03);
  if (rank(world) != 0) return;
  EXPECT_GT(outcomes.by_key.at("0").times.cpu, 0.08);
  EXPECT_LT(outcomes.by_key.at("1").times.cpu, 0.02);
  EXPECT_GE(outcomes.by_key.at("1").times.seconds, 0.1);
  EXPECT_EQ(report.calibration.report().at("a").tasks, 2);
}

TEST(RunTasks, WaitingForOthersOfAGroupIsNoWork) {
  // The last rank of the group lets the others wait.
  Outcomes outcomes;
  run_tasks(world, on_host({{.key = "wide", .width = size(world)}}), outcomes.hooks(),
            [](std::int64_t, MPI_Comm group) {
              if (rank(group) == size(group) - 1) sleep_for(0.3);
              agree(group, nullptr);
              return "{}";
            });
  if (rank(world) == 0) {
    EXPECT_LT(outcomes.by_key.at("wide").times.cpu, 0.1);
  }
}

TEST(RunTasks, WorksOnAPartOfTheRanks) {
  const int half = rank(world) % 2;
  Comm part;
  MPI_Comm_split(world, half, 0, part.put());
  TaskBoard board = rank(part.get()) == 0 ? TaskBoard(singles(20 + half)) : TaskBoard();
  const RunReport report =
      run_tasks(part.get(), std::move(board), {}, [](std::int64_t, MPI_Comm) { return "{}"; });
  EXPECT_EQ(report.done, 20 + half);
}

TEST(RunTasks, TimesOfARankAddUp) {
  const int n = 3 * size(world);
  MPI_Barrier(world);
  const double start = core::monotonic_seconds();
  const RunReport report = run_tasks(world, on_host(singles(n)), {}, [](std::int64_t, MPI_Comm) {
    sleep_for(0.05);
    return "{}";
  });
  const double wall = core::monotonic_seconds() - start;
  EXPECT_GE(report.times.busy, 0.05 * static_cast<double>(report.tasks_run));
  EXPECT_GE(report.times.idle, 0);
  EXPECT_LE(report.times.busy + report.times.idle, wall);
  EXPECT_EQ(sum(report.tasks_run, world), n);
}

TEST(RunTasks, ASignalOnOneRankEndsTheRunAndTheRestCanFollow) {
  for (int signalled = 0; signalled < size(world); ++signalled) {
    const InterruptGuard guard;
    const int n = 2000;
    Outcomes outcomes;
    int mine = 0;
    const RunReport report =
        run_tasks(world, on_host(singles(n)), outcomes.hooks(), [&](std::int64_t, MPI_Comm) {
          sleep_for(0.002);
          // One that never gets a second task would be a rank that the others starve.
          if (++mine == 2 && rank(world) == signalled) std::raise(SIGTERM);
          return "{}";
        });
    EXPECT_TRUE(report.interrupted);
    EXPECT_GT(report.open, 0);
    EXPECT_EQ(report.done + report.open, n);  // what was begun was finished
    if (rank(world) == 0) {
      EXPECT_EQ(static_cast<std::int64_t>(outcomes.by_key.size()), report.done);
    }

    const InterruptGuard again;
    TaskBoard rest = on_host(singles(n));
    for (std::int64_t i = 0; rank(world) == 0 && i < n; ++i) {
      if (report.board.state(i) == TaskState::done) rest.mark_done(i);
    }
    const RunReport second = run_tasks(world, std::move(rest), outcomes.hooks(),
                                       [](std::int64_t, MPI_Comm) { return "{}"; });
    EXPECT_FALSE(second.interrupted);
    EXPECT_EQ(second.done, n);
    EXPECT_EQ(sum(second.tasks_run, world), report.open);
  }
}

TEST(RunTasks, ASignalOnAGroupsLastRankReachesItsLeader) {
  std::vector<Task> tasks;
  for (int i = 0; i < 200; ++i) tasks.push_back({.key = std::to_string(i), .width = 4});
  const InterruptGuard guard;
  int mine = 0;
  const RunReport report = run_tasks(world, on_host(tasks), {}, [&](std::int64_t, MPI_Comm group) {
    if (++mine == 3 && rank(group) == size(group) - 1) std::raise(SIGUSR1);
    return "{}";
  });
  EXPECT_TRUE(report.interrupted);
  EXPECT_LE(report.done, 4);
}

TEST(RunTasks, ASignalDuringTheLastTaskInterruptsNothing) {
  const InterruptGuard guard;
  const RunReport report = run_tasks(world, on_host(singles(1)), {}, [](std::int64_t, MPI_Comm) {
    std::raise(SIGTERM);
    return "{}";
  });
  EXPECT_FALSE(report.interrupted);
  EXPECT_EQ(report.done, 1);
}

}  // namespace
}  // namespace carillon::mpi
