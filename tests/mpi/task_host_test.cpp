// The board with its hooks, asked by several threads at once.
#include "mpi/task_host.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>

namespace carillon::mpi {
namespace {

std::vector<Task> tasks(int n) {
  std::vector<Task> list;
  for (int i = 0; i < n; ++i) list.push_back({.key = std::to_string(i), .cost = 1});
  return list;
}

TEST(TaskHost, HooksSeeEveryTaskOneCallAtATime) {
  std::atomic<int> inside{0};
  std::atomic<bool> overlapped{false};
  const auto alone = [&] {
    if (++inside != 1) overlapped = true;
    std::this_thread::yield();
    --inside;
  };
  int completed = 0;
  double progress = 0;
  TaskHost host(TaskBoard(tasks(400)), {.completed =
                                            [&](const Task&, const Outcome& outcome) {
                                              alone();
                                              completed += outcome.record == "{}" ? 1 : 0;
                                            },
                                        .progress =
                                            [&](const TaskBoard& board) {
                                              alone();
                                              progress = board.settled_cost();
                                            }});
  std::vector<std::thread> workers;
  for (int w = 0; w < 4; ++w) {
    workers.emplace_back([&] {
      for (Claim claim = host.claim(1); claim.kind == Claim::Kind::task; claim = host.claim(1)) {
        host.complete(claim.task, {true, "{}"});
      }
    });
  }
  for (std::thread& worker : workers) worker.join();
  EXPECT_FALSE(overlapped);
  EXPECT_EQ(completed, 400);
  EXPECT_EQ(progress, 400);
  EXPECT_EQ(host.board().count(TaskState::done), 400);
}

TEST(TaskHost, StoppedMeansNoNewTaskAndWhatRunsIsStillRecorded) {
  int completed = 0;
  TaskHost host(TaskBoard(tasks(3)),
                {.completed = [&](const Task&, const Outcome&) { ++completed; }});
  const Claim claim = host.claim(1);
  host.stop();
  EXPECT_EQ(host.claim(1).kind, Claim::Kind::end);
  host.complete(claim.task, {});
  EXPECT_EQ(completed, 1);
  EXPECT_TRUE(host.stopped());
  EXPECT_FALSE(host.error());
  EXPECT_EQ(host.board().count(TaskState::waiting), 2);
}

TEST(TaskHost, AHookThatThrowsStopsTheRunAndIsKept) {
  TaskHost host(TaskBoard(tasks(3)), {.completed = [](const Task& task, const Outcome&) {
                  throw std::runtime_error("disk full at " + task.key);
                }});
  const Claim first = host.claim(1);
  const Claim second = host.claim(1);
  EXPECT_NO_THROW(host.complete(first.task, {}));
  EXPECT_EQ(host.claim(1).kind, Claim::Kind::end);
  EXPECT_NO_THROW(host.complete(second.task, {}));
  ASSERT_TRUE(host.error());
  try {
    std::rethrow_exception(host.error());
  } catch (const std::runtime_error& e) {
    EXPECT_STREQ(e.what(), "disk full at 0");
  }
}

TEST(TaskHost, AFailureTakesWhatItConcernsWithIt) {
  std::vector<Task> list = tasks(5);  // 1 does the same as 0, 2 waits for 1, 3 runs already
  list[2].after = {1};
  list[3].cost = 10;
  list[0].cost = 9;
  std::vector<std::pair<std::string, std::string>> ended;
  TaskHost host(TaskBoard(list), {.completed =
                                      [&](const Task& task, const Outcome& outcome) {
                                        ended.emplace_back(task.key, outcome.record);
                                      },
                                  .lost_with = [&](const Task& task) -> std::vector<std::int64_t> {
                                    if (task.key == list[0].key) return {1, 3};
                                    return {};
                                  }});
  EXPECT_EQ(host.claim(1).task, 3);
  EXPECT_EQ(host.claim(1).task, 0);
  host.complete(0, {false, "why"});
  EXPECT_EQ(ended, (std::vector<std::pair<std::string, std::string>>{{list[0].key, "why"},
                                                                     {list[1].key, "why"}}));
  EXPECT_EQ(host.board().state(1), TaskState::failed);
  EXPECT_EQ(host.board().state(2), TaskState::skipped);
  EXPECT_EQ(host.board().state(3), TaskState::running);
  EXPECT_EQ(host.claim(1).task, 4);
  // What is done takes nothing with it.
  host.complete(3, {true, "well"});
  host.complete(4, {false, "alone"});
  EXPECT_EQ(ended.size(), 4u);
}

}  // namespace
}  // namespace carillon::mpi
