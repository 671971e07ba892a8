// What a process leaves behind, for every way it can end.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <thread>

#include "core/temporary_folder.hpp"
#include "mpi/interrupt.hpp"
#include "mpi/witness.hpp"

namespace carillon::mpi {
namespace {

using End = Testimony::End;

void sleep_for(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

/// Goes deeper than any stack.
[[gnu::noinline]] int deeper(volatile int* before) {
  if (*before < 0) return 0;  // it never is, but compilers dislike a stack without end
  volatile int here[256];
  here[0] = *before + 1;
  return deeper(here) + here[0];
}

class WitnessTest : public ::testing::Test {
 protected:
  /// Runs `work` in a process of its own that has a witness and a task. @return wait()'s status
  int in_child(const std::function<void(Witness&)>& work) {
    const pid_t child = fork();
    if (child == 0) {
      const rlimit no_core{0, 0};
      setrlimit(RLIMIT_CORE, &no_core);
      // Sanitizers have handlers of their own, which would report what is meant to happen.
      for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) ::signal(signal, SIG_DFL);
      {
        const InterruptGuard guard;
        Witness witness(folder_.path() / "running" / "rank-00000", 2, 77);
        witness.begin("modes/bowl");
        witness.enter("solve", "", 0, "");
        work(witness);
      }
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return status;
  }

  Testimony left() {
    const auto all = read_testimonies(folder_.path() / "running");
    EXPECT_EQ(all.size(), 1U);
    return all.empty() ? Testimony{} : all.front();
  }

  core::TemporaryFolder folder_;
};

TEST_F(WitnessTest, ACleanEndLeavesNothing) {
  EXPECT_EQ(in_child([](Witness& witness) { witness.end(); }), 0);
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "running"));
}

TEST_F(WitnessTest, EverySignalOfACrashIsNoted) {
  const std::pair<int, const char*> signals[] = {{SIGSEGV, "SIGSEGV"},
                                                 {SIGBUS, "SIGBUS"},
                                                 {SIGFPE, "SIGFPE"},
                                                 {SIGILL, "SIGILL"},
                                                 {SIGABRT, "SIGABRT"}};
  for (const auto& [signal, name] : signals) {
    const int status = in_child([signal = signal](Witness&) { raise(signal); });
    EXPECT_TRUE(WIFSIGNALED(status));
    EXPECT_EQ(WTERMSIG(status), signal) << "it still dies of it";
    const Testimony told = left();
    EXPECT_EQ(told.end, End::crashed);
    EXPECT_EQ(told.words, name);
    EXPECT_EQ(told.task, "modes/bowl");
    EXPECT_EQ(told.stage, "solve");
    EXPECT_EQ(told.ranks, 2);
    EXPECT_EQ(told.host.name, this_host().name);
  }
}

TEST_F(WitnessTest, FaultsAreNotedTooAndAnOverflownStack) {
  int status = in_child([](Witness&) {
    volatile int* nowhere = nullptr;
    *nowhere = 1;
  });
  EXPECT_EQ(WTERMSIG(status), SIGSEGV);
  EXPECT_EQ(left().words, "SIGSEGV");
  status = in_child([](Witness&) {
    volatile int start = 0;
    deeper(&start);
  });
  EXPECT_EQ(WTERMSIG(status), SIGSEGV);
  EXPECT_EQ(left().words, "SIGSEGV");
}

TEST_F(WitnessTest, AKillIsSilentAndTheMemoryIsKnown) {
  const int status = in_child([](Witness& witness) {
    witness.enter("sound", "bowl/glass/1/strike-0003", 0, "");
    sleep_for(0.8);
    raise(SIGKILL);
  });
  EXPECT_EQ(WTERMSIG(status), SIGKILL);
  const Testimony told = left();
  EXPECT_EQ(told.end, End::silent);
  EXPECT_EQ(told.stage, "sound");
  EXPECT_EQ(told.item, "bowl/glass/1/strike-0003");
  EXPECT_GT(told.resident, 1 << 20);
}

TEST_F(WitnessTest, WhoWasAskedToStopSaysSo) {
  in_child([](Witness&) {
    raise(SIGTERM);
    sleep_for(0.3);
    raise(SIGKILL);
  });
  EXPECT_EQ(left().end, End::stopped);
}

TEST_F(WitnessTest, AHangIsEnded) {
  const int status = in_child([](Witness& witness) {
    witness.enter("solve", "", 0.2, "the solve takes longer than the limit of 0.1 s");
    sleep_for(60);
  });
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 77);
  const Testimony told = left();
  EXPECT_EQ(told.end, End::overdue);
  EXPECT_EQ(told.words, "the solve takes longer than the limit of 0.1 s");
}

TEST_F(WitnessTest, APartInTimeIsLeftAlone) {
  const int status = in_child([](Witness& witness) {
    witness.enter("solve", "", 0.2, "too long");
    witness.enter("write", "", 0, "");
    sleep_for(0.5);
    witness.end();
  });
  EXPECT_EQ(status, 0);
}

TEST_F(WitnessTest, BetweenTasksThereIsNothingToTell) {
  in_child([](Witness& witness) {
    witness.end();
    raise(SIGKILL);
  });
  EXPECT_TRUE(read_testimonies(folder_.path() / "running").empty());
}

TEST_F(WitnessTest, WhatCannotBeReadTellsNothing) {
  EXPECT_TRUE(read_testimonies(folder_.path() / "nowhere").empty());
  std::filesystem::create_directories(folder_.path() / "running");
  std::ofstream(folder_.path() / "running" / "empty");
  std::ofstream(folder_.path() / "running" / "cut") << "{\"task\": \"mod";
  std::ofstream(folder_.path() / "running" / "odd") << "{\"task\": 7}\n";
  EXPECT_TRUE(read_testimonies(folder_.path() / "running").empty());
}

TEST_F(WitnessTest, NamesWithoutEndDoNotSpoilTheRest) {
  in_child([](Witness& witness) {
    witness.enter("sound", std::string(10000, 'x'), 0, "");
    raise(SIGSEGV);
  });
  const Testimony told = left();
  EXPECT_EQ(told.task, "modes/bowl");
  EXPECT_EQ(told.words, "SIGSEGV");
}

}  // namespace
}  // namespace carillon::mpi
