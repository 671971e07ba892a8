// What a process leaves behind of its task, for every way it can end.
#include "mpi/running_task.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <functional>
#include <thread>

#include "core/temporary_folder.hpp"
#include "mpi/interrupt.hpp"

namespace carillon::mpi {
namespace {

void sleep_for(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

class RunningTaskTest : public ::testing::Test {
 protected:
  /// Runs `work` in a process of its own that has begun a task. @return wait()'s status
  int in_child(const std::function<void(RunningTask&)>& work) {
    const pid_t child = fork();
    if (child == 0) {
      const rlimit no_core{0, 0};
      setrlimit(RLIMIT_CORE, &no_core);
      // Sanitizers have handlers of their own, which would report what is meant to happen.
      for (const int signal : {SIGSEGV, SIGABRT}) ::signal(signal, SIG_DFL);
      {
        const InterruptGuard guard;
        RunningTask running(folder_.path() / "running" / "rank-00000", 77);
        running.begin("modes/bowl");
        running.enter("solve", "", 0, "");
        work(running);
      }
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return status;
  }

  std::vector<BegunTask> left() { return begun_tasks(folder_.path() / "running"); }

  core::TemporaryFolder folder_;
};

TEST_F(RunningTaskTest, ACleanEndLeavesNothing) {
  EXPECT_EQ(in_child([](RunningTask& running) { running.end(); }), 0);
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "running"));
}

TEST_F(RunningTaskTest, HoweverTheProcessEndsItsTaskIsKnown) {
  for (const int signal : {SIGSEGV, SIGABRT, SIGKILL}) {
    const int status = in_child([signal](RunningTask& running) {
      running.enter("sound", "bowl/glass/1/strike-0003", 0, "");
      raise(signal);
    });
    EXPECT_TRUE(WIFSIGNALED(status));
    EXPECT_EQ(WTERMSIG(status), signal);
    ASSERT_EQ(left().size(), 1U);
    EXPECT_EQ(left()[0].task, "modes/bowl");
    EXPECT_EQ(left()[0].stage, "sound");
    EXPECT_EQ(left()[0].item, "bowl/glass/1/strike-0003");
    EXPECT_EQ(left()[0].overdue, "");
  }
  in_child([](RunningTask&) { _exit(1); });
  EXPECT_EQ(left().size(), 1U);
}

TEST_F(RunningTaskTest, WhoWasAskedToStopLeavesNoTask) {
  for (const int signal : {SIGTERM, SIGINT, SIGUSR1}) {
    in_child([signal](RunningTask& running) {
      raise(signal);
      sleep_for(0.3);
      running.enter("write", "", 0, "");
      raise(SIGKILL);
    });
    EXPECT_TRUE(left().empty());
  }
}

TEST_F(RunningTaskTest, AHangIsEnded) {
  const int status = in_child([](RunningTask& running) {
    running.enter("solve", "", 0.2, "the solve takes longer than the limit of 0.1 s");
    sleep_for(60);
  });
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 77);
  ASSERT_EQ(left().size(), 1U);
  EXPECT_EQ(left()[0].stage, "solve");
  EXPECT_EQ(left()[0].overdue, "the solve takes longer than the limit of 0.1 s");
}

TEST_F(RunningTaskTest, APartInTimeIsLeftAlone) {
  const int status = in_child([](RunningTask& running) {
    running.enter("solve", "", 0.2, "too long");
    running.enter("write", "", 0, "");
    sleep_for(0.5);
    running.end();
  });
  EXPECT_EQ(status, 0);
}

TEST_F(RunningTaskTest, BetweenTasksNoneIsNoted) {
  in_child([](RunningTask& running) {
    running.end();
    raise(SIGKILL);
  });
  EXPECT_TRUE(left().empty());
}

TEST_F(RunningTaskTest, AShorterLineTakesThePlaceOfALongerOne) {
  in_child([](RunningTask& running) {
    running.enter("sound", std::string(10000, 'x'), 0, "");
    running.begin("modes/cup");
    raise(SIGKILL);
  });
  ASSERT_EQ(left().size(), 1U);
  EXPECT_EQ(left()[0].task, "modes/cup");
  EXPECT_EQ(left()[0].item, "");
}

TEST_F(RunningTaskTest, WhatCannotBeReadTellsNothing) {
  EXPECT_TRUE(begun_tasks(folder_.path() / "nowhere").empty());
  std::filesystem::create_directories(folder_.path() / "running");
  std::ofstream(folder_.path() / "running" / "empty") << "";
  std::ofstream(folder_.path() / "running" / "cut") << "{\"task\": \"mod";
  std::ofstream(folder_.path() / "running" / "odd") << "{\"task\": 7}\n";
  EXPECT_TRUE(left().empty());
}

}  // namespace
}  // namespace carillon::mpi
