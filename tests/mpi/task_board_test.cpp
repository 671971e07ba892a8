#include "mpi/task_board.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <limits>

#include "core/error.hpp"

namespace carillon::mpi {
namespace {

Task task(std::string key, double cost, std::vector<std::int64_t> after = {}, int width = 1) {
  return {.key = std::move(key), .cost = cost, .width = width, .after = std::move(after)};
}

std::string message_of(std::vector<Task> tasks) {
  try {
    const TaskBoard board(std::move(tasks));
  } catch (const core::Error& e) {
    return e.message();
  }
  return "accepted";
}

void expect_task(const Claim& claim, std::int64_t index) {
  EXPECT_EQ(claim.kind, Claim::Kind::task);
  EXPECT_EQ(claim.task, index);
}

TEST(TaskBoard, AnEmptyBoardIsAtItsEnd) {
  TaskBoard board;
  EXPECT_EQ(board.claim(1).kind, Claim::Kind::end);
  EXPECT_EQ(board.total_cost(), 0);
}

TEST(TaskBoard, DearestFirstAndEqualCostsInOrder) {
  TaskBoard board({task("a", 1), task("b", 5), task("c", 5), task("d", 3)});
  for (const std::int64_t expected : {1, 2, 3, 0}) expect_task(board.claim(1), expected);
  EXPECT_EQ(board.claim(1).kind, Claim::Kind::end);
}

TEST(TaskBoard, WaitsForWhatIsRunningElsewhere) {
  TaskBoard board({task("modes", 1), task("samples", 9, {0})});
  expect_task(board.claim(1), 0);
  EXPECT_EQ(board.claim(1).kind, Claim::Kind::wait);
  board.complete(0, true);
  expect_task(board.claim(1), 1);
  EXPECT_EQ(board.state(1), TaskState::running);
  board.complete(1, true);
  EXPECT_EQ(board.claim(1).kind, Claim::Kind::end);
  EXPECT_EQ(board.count(TaskState::done), 2);
}

TEST(TaskBoard, OneThatRunsAloneIsTheLastAndHasNothingBesideIt) {
  TaskBoard board(
      {task("suspect", 9), task("a", 1), task("b", 2), task("sounds", 1, {0}), task("other", 5)});
  std::vector<Task> tasks = board.tasks();
  tasks[0].alone = tasks[4].alone = true;
  board = TaskBoard(tasks);
  expect_task(board.claim(1), 2);
  expect_task(board.claim(1), 1);
  EXPECT_EQ(board.claim(1).kind, Claim::Kind::wait);
  board.complete(1, true);
  EXPECT_EQ(board.claim(1).kind, Claim::Kind::wait);
  board.complete(2, true);
  expect_task(board.claim(1), 0);
  EXPECT_EQ(board.claim(1).kind, Claim::Kind::wait);
  board.complete(0, true);
  // What waited for it is a task like others, and goes before the next one.
  expect_task(board.claim(1), 3);
  EXPECT_EQ(board.claim(1).kind, Claim::Kind::wait);
  board.complete(3, true);
  expect_task(board.claim(1), 4);
  board.complete(4, false);
  EXPECT_EQ(board.claim(1).kind, Claim::Kind::end);
}

TEST(TaskBoard, NarrowerTasksWaitForAWiderOneThatRunsAlone) {
  TaskBoard board({{.key = "wide", .cost = 1, .width = 2, .alone = true}, task("narrow", 1)});
  board.set_ranks(3);
  EXPECT_EQ(board.claim(1, 2).kind, Claim::Kind::wait);
  expect_task(board.claim(2, 0), 0);
  EXPECT_EQ(board.claim(1, 2).kind, Claim::Kind::wait);
  board.complete(0, true);
  EXPECT_EQ(board.claim(2, 0).kind, Claim::Kind::end);
  expect_task(board.claim(1, 2), 1);
}

TEST(TaskBoard, AFailureSkipsAllThatDependsOnIt) {
  TaskBoard board({task("a", 1), task("b", 2, {0}), task("c", 4, {1}), task("d", 8)});
  expect_task(board.claim(1), 3);
  expect_task(board.claim(1), 0);
  board.complete(0, false);
  EXPECT_EQ(board.state(1), TaskState::skipped);
  EXPECT_EQ(board.state(2), TaskState::skipped);
  EXPECT_EQ(board.settled_cost(), 7);
  EXPECT_EQ(board.claim(1).kind, Claim::Kind::end);
  board.complete(3, true);
  EXPECT_EQ(board.settled_cost(), board.total_cost());
}

TEST(TaskBoard, WhoIsBehindWaitsForAnEndWellOrNot) {
  for (const bool ok : {true, false}) {
    TaskBoard board({task("first", 1), task("behind", 5)});
    std::vector<Task> tasks = board.tasks();
    tasks[1].behind = {0};
    board = TaskBoard(tasks);
    expect_task(board.claim(1), 0);
    EXPECT_EQ(board.claim(1).kind, Claim::Kind::wait);
    board.complete(0, ok);
    expect_task(board.claim(1), 1);
  }
}

TEST(TaskBoard, WhoIsBehindASkippedOrSettledTaskGoesOn) {
  std::vector<Task> tasks = {task("lost", 1), task("skipped", 5, {0}), task("behind", 9)};
  tasks[2].behind = {1};
  TaskBoard board(tasks);
  expect_task(board.claim(1), 0);
  board.complete(0, false);
  EXPECT_EQ(board.state(1), TaskState::skipped);
  expect_task(board.claim(1), 2);
  TaskBoard again(tasks);
  again.mark_failed(0);
  expect_task(again.claim(1), 2);
}

TEST(TaskBoard, CirclesThroughBehindAreRefused) {
  std::vector<Task> tasks = {task("a", 1), task("b", 1, {0})};
  tasks[0].behind = {1};
  EXPECT_NE(message_of(tasks).find("waits for itself"), std::string::npos);
  tasks[0].behind = {7};
  EXPECT_NE(message_of(tasks).find("there are 2 tasks"), std::string::npos);
}

TEST(TaskBoard, GroupsTakeTheirWidthAndSinglesTheirs) {
  TaskBoard board({task("small", 9), task("huge", 1, {}, 4), task("after huge", 5, {1})});
  board.set_ranks(2);
  EXPECT_EQ(board.claim(4).kind, Claim::Kind::end);
  expect_task(board.claim(2), 1);
  EXPECT_EQ(board.claim(2).kind, Claim::Kind::end);
  expect_task(board.claim(1), 0);
  EXPECT_EQ(board.claim(1).kind, Claim::Kind::wait);
  board.complete(1, true);
  expect_task(board.claim(1), 2);
  EXPECT_THROW(board.set_ranks(1), core::Error);
}

TEST(TaskBoard, WhatFindsNoMemoryIsPassedOver) {
  std::vector<Task> tasks{task("large", 9), task("larger", 8), task("small", 1)};
  tasks[0].memory = 60;
  tasks[1].memory = 70;
  tasks[2].memory = 20;
  TaskBoard board(tasks);
  board.set_ranks(3, {{0, 0, 0}, {100}});
  expect_task(board.claim(1, 0), 0);
  expect_task(board.claim(1, 1), 2);
  EXPECT_EQ(board.claim(1, 2).kind, Claim::Kind::wait);
  board.complete(0, true);
  expect_task(board.claim(1, 2), 1);
  EXPECT_EQ(board.memory().held().front(), 90);
}

TEST(TaskBoard, MemoryCountsNodeByNode) {
  std::vector<Task> tasks{task("wide", 9, {}, 2), task("a", 5), task("b", 4), task("huge", 1)};
  tasks[0].memory = 100;
  tasks[1].memory = tasks[2].memory = 60;
  tasks[3].memory = 300;
  TaskBoard board(tasks);
  // Ranks 0 and 1 are apart, so each node holds half of the wide task; 2 is on a third.
  board.set_ranks(3, {{0, 1, 2}, {100, 100, 200}});
  EXPECT_EQ(board.fit_nowhere(), std::vector<std::int64_t>{3});
  board.mark_failed(3);
  expect_task(board.claim(2, 0), 0);
  expect_task(board.claim(1, 2), 1);
  expect_task(board.claim(1, 2), 2);
  EXPECT_EQ(board.memory().held(), (std::vector<std::int64_t>{50, 50, 120}));
}

TEST(TaskBoard, AGroupEndsWhenOnlyOthersCanHoldTheRest) {
  std::vector<Task> tasks{task("large", 9)};
  tasks[0].memory = 100;
  TaskBoard board(tasks);
  board.set_ranks(2, {{0, 1}, {50, 100}});
  EXPECT_TRUE(board.fit_nowhere().empty());
  EXPECT_EQ(board.claim(1, 0).kind, Claim::Kind::end);
  expect_task(board.claim(1, 1), 0);
}

TEST(TaskBoard, FactorsOfKindsChangeTheOrderAndTheSums) {
  std::vector<Task> tasks{task("a", 4), task("b", 3), task("c", 2), task("d", 1, {2})};
  tasks[0].kind = tasks[1].kind = "slow";
  tasks[2].kind = tasks[3].kind = "quick";
  TaskBoard board(tasks);
  expect_task(board.claim(1), 0);
  board.set_factor("slow", 0.5);
  EXPECT_EQ(board.total_cost(), 6.5);
  expect_task(board.claim(1), 2);
  board.complete(2, true);
  EXPECT_EQ(board.settled_cost(), 2);
  board.set_factor("quick", 2);
  EXPECT_EQ(board.settled_cost(), 4);
  expect_task(board.claim(1), 3);
  expect_task(board.claim(1), 1);
}

TEST(TaskBoard, ResumesFromWhatIsDone) {
  TaskBoard board({task("a", 1), task("b", 2, {0}), task("c", 4, {1}), task("d", 8, {1})});
  board.mark_done(2);  // done although what it depends on is not
  board.mark_done(0);
  board.mark_done(0);
  expect_task(board.claim(1), 1);
  board.complete(1, false);
  EXPECT_EQ(board.state(2), TaskState::done);
  EXPECT_EQ(board.state(3), TaskState::skipped);
  EXPECT_EQ(board.claim(1).kind, Claim::Kind::end);
  EXPECT_THROW(board.mark_done(3), core::Error);
}

TEST(TaskBoard, QuarantineSkipsWhatIsNotDone) {
  TaskBoard board({task("a", 1), task("b", 2, {0}), task("c", 4, {0}), task("d", 8, {1})});
  board.mark_done(1);
  board.mark_failed(0);
  EXPECT_EQ(board.state(2), TaskState::skipped);
  EXPECT_THROW(board.mark_done(0), core::Error);
  EXPECT_THROW(board.mark_done(2), core::Error);
  expect_task(board.claim(1), 3);
  EXPECT_THROW(board.mark_failed(3), core::Error);
}

TEST(TaskBoard, RefusesListsThatCannotBeWorkedOff) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(message_of({task("a", 1, {1})}), "task 'a' waits for task 1, but there are 1 tasks");
  EXPECT_EQ(message_of({task("a", 1, {-1})}), "task 'a' waits for task -1, but there are 1 tasks");
  EXPECT_EQ(message_of({task("a", 1), task("a", 1)}), "two tasks have the key 'a'");
  EXPECT_EQ(message_of({task("a", 1, {}, 0)}), "task 'a' wants 0 ranks");
  EXPECT_EQ(message_of({task("a", nan)}), "task 'a' has an estimate of nan s and 0 bytes");
  EXPECT_EQ(message_of({task("a", -1)}), "task 'a' has an estimate of -1 s and 0 bytes");
  EXPECT_EQ(message_of({task("a", 1), task("b", 1, {0}, 2)}),
            "task 'b' for 2 ranks waits for the narrower task 'a' for 1");
}

TEST(TaskBoard, NamesATaskOnTheCircleAndNotOneThatHangsOnIt) {
  const std::string circle = "waits for itself, by a circle of tasks that wait for each other";
  EXPECT_EQ(message_of({task("a", 1, {0})}), "task 'a' " + circle);
  // z waits for the circle of b and c; it is no part of it.
  const std::string message =
      message_of({task("z", 1, {1}), task("b", 1, {2}), task("c", 1, {1, 3}), task("free", 1)});
  EXPECT_TRUE(message == "task 'b' " + circle || message == "task 'c' " + circle) << message;
}

TEST(TaskBoard, RefusesCallsThatMakeNoModality) {
  TaskBoard board({task("a", 1), task("b", 1)});
  EXPECT_THROW(board.complete(0, true), core::Error);
  EXPECT_THROW(board.state(2), core::Error);
  EXPECT_THROW(board.set_ranks(0), core::Error);
  EXPECT_THROW(board.set_ranks(2, {{0}, {1}}), core::Error);
  EXPECT_THROW(board.set_factor("", 0), core::Error);
  expect_task(board.claim(1), 0);
  board.complete(0, true);
  EXPECT_THROW(board.complete(0, true), core::Error);
  EXPECT_THROW(board.complete(-1, true), core::Error);
}

TEST(TaskBoard, ADependencyThatIsListedTwiceIsMetOnce) {
  TaskBoard board({task("a", 1), task("b", 1, {0, 0})});
  expect_task(board.claim(1), 0);
  board.complete(0, true);
  expect_task(board.claim(1), 1);
}

// A scan of the list for each claim would take minutes here.
TEST(TaskBoard, AHundredThousandTasks) {
  const std::int64_t shapes = 20'000;
  std::vector<Task> tasks;
  for (std::int64_t i = 0; i < shapes; ++i) {
    tasks.push_back(task("modes/" + std::to_string(i), static_cast<double>(i % 977)));
  }
  for (std::int64_t i = 0; i < 4 * shapes; ++i) {
    tasks.push_back(task("samples/" + std::to_string(i), 1, {i % shapes}));
  }
  const auto start = std::chrono::steady_clock::now();
  TaskBoard board(std::move(tasks));
  std::int64_t claimed = 0;
  for (Claim claim = board.claim(1); claim.kind == Claim::Kind::task; claim = board.claim(1)) {
    board.complete(claim.task, true);
    ++claimed;
  }
  EXPECT_EQ(claimed, 5 * shapes);
  EXPECT_EQ(board.count(TaskState::done), 5 * shapes);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  EXPECT_LT(seconds.count(), 10);
}

/// Seconds that claims take, the least of some tries: one of 4 ranks holds all memory but a little,
/// and n large tasks are dearer than the small ones that still fit.
double seconds_of_claims(std::int64_t n) {
  constexpr int claims = 2000;
  std::vector<Task> tasks{{.key = "holder", .cost = 1e6, .memory = 90}};
  for (std::int64_t i = 0; i < n; ++i) {
    tasks.push_back({.key = std::to_string(i), .cost = 1.0 + double(i % 977), .memory = 50});
  }
  for (int i = 0; i < claims; ++i) {
    tasks.push_back({.key = "small " + std::to_string(i), .cost = 0.5, .memory = 1});
  }
  double minimum = 1e300;
  for (int repeat = 0; repeat < 5; ++repeat) {
    TaskBoard board(tasks);
    board.set_ranks(4, {{0, 0, 0, 0}, {100}});
    expect_task(board.claim(1, 0), 0);
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < claims; ++i) {
      const Claim claim = board.claim(1, 1);
      EXPECT_EQ(claim.task, n + 1 + i);
      board.complete(claim.task, true);
    }
    for (int i = 0; i < claims; ++i) EXPECT_EQ(board.claim(1, 2).kind, Claim::Kind::wait);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    minimum = std::min(minimum, seconds.count());
  }
  return minimum;
}

TEST(TaskBoard, TasksThatFindNoMemoryAreNotLookedAtOneByOne) {
  // A look at each would take a thousand times as long.
  EXPECT_LT(seconds_of_claims(100'000) / seconds_of_claims(100), 10);
}

}  // namespace
}  // namespace carillon::mpi
