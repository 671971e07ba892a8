#include "mpi/interrupt.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstring>
#include <functional>
#include <optional>
#include <string>

#include "core/termination_blocked.hpp"

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

/// How a child ends that is deep in its work when the signal comes, after how many seconds, and
/// what it said on its way out.
struct End {
  int status = 0;
  double seconds = 0;
  std::string words;
};
End end_of_busy_child(int signal, std::function<void(int pipe)> words, bool blocked = false) {
  std::array<int, 2> ends{};
  EXPECT_EQ(pipe(ends.data()), 0);
  const pid_t child = fork();
  if (child == 0) {
    const InterruptGuard guard(
        {.last_words = [&] { words(ends[1]); }, .grace = std::chrono::milliseconds(200)});
    std::optional<core::TerminationBlocked> undisturbed;
    if (blocked) undisturbed.emplace();
    kill(getpid(), signal);
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(3);
    while (std::chrono::steady_clock::now() < end) continue;
    _exit(42);
  }
  const auto begin = std::chrono::steady_clock::now();
  End end;
  waitpid(child, &end.status, 0);
  end.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  close(ends[1]);
  std::array<char, 64> text{};
  const ssize_t length = read(ends[0], text.data(), text.size());
  end.words.assign(text.data(), length > 0 ? static_cast<std::size_t>(length) : 0);
  close(ends[0]);
  return end;
}

void say(int pipe, const char* word) {
  ASSERT_GT(write(pipe, word, std::strlen(word)), 0);
}

TEST(Interrupt, ABusyProgramIsOutWithinTheGraceAfterItsLastWords) {
  for (const int signal : {SIGTERM, SIGINT}) {
    const End end = end_of_busy_child(signal, [](int pipe) { say(pipe, "bye"); });
    EXPECT_TRUE(WIFEXITED(end.status) && WEXITSTATUS(end.status) == interrupted_code);
    EXPECT_GE(end.seconds, 0.15);
    EXPECT_LT(end.seconds, 2.5);
    EXPECT_EQ(end.words, "bye");
  }
}

TEST(Interrupt, ASignalThatNoThreadTakesIsHeard) {
  const End end = end_of_busy_child(
      SIGTERM, [](int pipe) { say(pipe, "bye"); }, true);
  EXPECT_TRUE(WIFEXITED(end.status) && WEXITSTATUS(end.status) == interrupted_code);
  EXPECT_LT(end.seconds, 2.5);
  EXPECT_EQ(end.words, "bye");
}

TEST(Interrupt, LastWordsThatHangAreCutOff) {
  const End end = end_of_busy_child(SIGTERM, [](int pipe) {
    say(pipe, "well");
    for (;;) pause();
  });
  EXPECT_TRUE(WIFEXITED(end.status) && WEXITSTATUS(end.status) == interrupted_code);
  EXPECT_LT(end.seconds, 2.5);
  EXPECT_EQ(end.words, "well");
}

TEST(Interrupt, ThePatientSignalGivesNothingUp) {
  const End end = end_of_busy_child(SIGUSR1, [](int pipe) { say(pipe, "bye"); });
  EXPECT_TRUE(WIFEXITED(end.status) && WEXITSTATUS(end.status) == 42);
  EXPECT_EQ(end.words, "");
}

TEST(Interrupt, AProgramThatGetsOutByItselfEndsAsItLikes) {
  const pid_t child = fork();
  if (child == 0) {
    {
      const InterruptGuard guard({.last_words = {}, .grace = std::chrono::milliseconds(100)});
      raise(SIGTERM);
    }
    usleep(300000);
    _exit(42);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 42);
}

TEST(Interrupt, OutsideOfAGuardTheProgramEndsAtOnce) {
  for (const bool ignored : {false, true}) {
    const pid_t child = fork();
    if (child == 0) {
      std::signal(SIGTERM, ignored ? SIG_IGN : SIG_DFL);
      leave_on_interrupt();
      raise(SIGTERM);
      _exit(42);
    }
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_EQ(WIFEXITED(status) ? WEXITSTATUS(status) : -1, ignored ? 42 : interrupted_code);
  }
}

}  // namespace
}  // namespace carillon::mpi
