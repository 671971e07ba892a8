#include "mpi/interrupt.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <ctime>

#include "core/temporary_folder.hpp"
#include "core/termination_blocked.hpp"
#include "mpi/launcher.hpp"

namespace carillon::mpi {

namespace {

// What a signal handler can reach of the process, and all that it touches.
std::atomic<bool> requested{false};
std::atomic<bool> leave_now{false};
sem_t wake;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may touch nothing else");

extern "C" void request_interrupt(int signal) {
  const int error = errno;
  requested.store(true);
  if (signal != SIGUSR1) {
    leave_now.store(true);
    sem_post(&wake);
  }
  errno = error;
}

// Of rank 0 alone, "" of the others.
const char* farewell = "";

/// Ends the process without the temporary files that nobody needs any more.
[[noreturn]] void leave_tidily() {
  core::remove_temporary_folders();
  _exit(interrupted_code);
}

extern "C" void leave(int) {
  // Whether it could be said changes nothing.
  [[maybe_unused]] const ssize_t said = ::write(STDERR_FILENO, farewell, std::strlen(farewell));
  leave_tidily();
}

/// SIGTERM came while no thread takes it.
bool termination_waits() {
  sigset_t pending;
  sigemptyset(&pending);
  sigpending(&pending);
  return sigismember(&pending, SIGTERM) == 1;
}

}  // namespace

void leave_on_interrupt() {
  if (launcher_rank().value_or(0) == 0) {
    farewell =
        "\ncarillon: interrupted\n  hint: run the same command again to go on; what was finished "
        "and what is in the cache is kept\n";
  }
  for (const int signal : {SIGINT, SIGTERM}) {
    struct sigaction former {};
    sigaction(signal, nullptr, &former);
    if (former.sa_handler == SIG_IGN) continue;
    struct sigaction action {};
    action.sa_handler = leave;
    sigemptyset(&action.sa_mask);
    sigaction(signal, &action, nullptr);
  }
  ::signal(SIGXFSZ, SIG_IGN);
}

InterruptGuard::InterruptGuard() {
  install();
}

InterruptGuard::InterruptGuard(Leaving leaving) : leaving_(std::move(leaving)) {
  install();
  const core::TerminationBlocked blocked;
  watcher_ = std::thread([this] { watch(); });
}

void InterruptGuard::install() {
  requested.store(false);
  leave_now.store(false);
  sem_init(&wake, 0, 0);
  for (std::size_t i = 0; i < signals.size(); ++i) {
    struct sigaction action {};
    action.sa_handler = request_interrupt;
    sigemptyset(&action.sa_mask);
    // Calls that were under way go on. Only SIGINT comes from an impatient person twice; batch
    // systems may well send SIGTERM to mpirun and to its ranks.
    action.sa_flags = SA_RESTART;
    if (signals[i] == SIGINT) action.sa_flags |= static_cast<int>(SA_RESETHAND);
    sigaction(signals[i], &action, &former_[i]);
  }
}

/// Sleeps until a signal or the guard's end; after a signal the process is gone within the grace. A
/// signal that waits, because the main thread cannot be disturbed, wakes nobody.
void InterruptGuard::watch() {
  constexpr long look_every_ns = 50'000'000;
  while (!leave_now.load() && !ending_.load()) {
    timespec until{};
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_nsec += look_every_ns;
    until.tv_sec += until.tv_nsec / 1'000'000'000;
    until.tv_nsec %= 1'000'000'000;
    sem_timedwait(&wake, &until);
    if (termination_waits()) request_interrupt(SIGTERM);
  }
  if (ending_.load()) return;
  const auto deadline = std::chrono::steady_clock::now() + leaving_.grace;
  if (leaving_.last_words) last_words_ = std::thread(leaving_.last_words);
  while (std::chrono::steady_clock::now() < deadline) {
    if (ending_.load()) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  // Whatever runs here holds nothing that a kill would spoil: files appear whole, and the
  // journal's lines are on the disk. MPI_Finalize would wait for ranks that are deep in their work.
  leave_tidily();
}

InterruptGuard::~InterruptGuard() {
  for (std::size_t i = 0; i < signals.size(); ++i) sigaction(signals[i], &former_[i], nullptr);
  ending_.store(true);
  sem_post(&wake);
  if (watcher_.joinable()) watcher_.join();
  if (last_words_.joinable()) last_words_.join();
  requested.store(false);
  leave_now.store(false);
}

bool interrupt_requested() {
  return requested.load();
}

}  // namespace carillon::mpi
