#include "mpi/interrupt.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

namespace carillon::mpi {
namespace {

TEST(Interrupt, EachOfTheSignalsAsksToStop) {
  for (const int signal : {SIGINT, SIGTERM, SIGUSR1}) {
    const InterruptGuard guard;
    EXPECT_FALSE(interrupt_requested());
    raise(signal);
    EXPECT_TRUE(interrupt_requested());
  }
  EXPECT_FALSE(interrupt_requested());
}

TEST(Interrupt, FormerHandlersComeBack) {
  std::signal(SIGUSR1, SIG_IGN);
  { const InterruptGuard guard; }
  EXPECT_EQ(std::signal(SIGUSR1, SIG_DFL), SIG_IGN);
}

/// How a child ends that gets the same signal twice under a guard.
int status_after_two(int signal) {
  const pid_t child = fork();
  if (child == 0) {
    const InterruptGuard guard;
    raise(signal);
    raise(signal);
    _exit(42);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return status;
}

TEST(Interrupt, ASecondSigintEndsTheProgramAtOnce) {
  const int interrupted = status_after_two(SIGINT);
  EXPECT_TRUE(WIFSIGNALED(interrupted) && WTERMSIG(interrupted) == SIGINT);
  // Batch systems may send it to mpirun, which sends it on, and to the ranks themselves.
  const int terminated = status_after_two(SIGTERM);
  EXPECT_TRUE(WIFEXITED(terminated) && WEXITSTATUS(terminated) == 42);
}

}  // namespace
}  // namespace carillon::mpi
