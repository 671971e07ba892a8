#pragma once

#include <semaphore.h>
#include <signal.h>

#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <thread>

namespace carillon::mpi {

/// Exit code of a program that a signal ended.
constexpr int interrupted_code = 130;

/// For main(), before anything else: SIGINT and SIGTERM end the program at once with exit code 130,
/// a word how to go on and no temporary folders (not where they are ignored, as under nohup), and a
/// file that would exceed the limit of sizes (SIGXFSZ) is a failed write with a message instead of
/// the program's end.
void leave_on_interrupt();

/// While one lives, SIGINT, SIGTERM and SIGUSR1 ask the program to stop instead of ending it: no
/// new tasks begin.
///
/// SIGUSR1 is the patient one: the tasks that run are finished. Open MPI's mpirun passes it on to
/// the ranks and kills nothing; batch systems send it before time is up
/// (`sbatch --signal=B:USR1@120`). SIGINT and SIGTERM give up what runs, when the guard was made
/// with a Leaving: a rank that is not out by itself within the grace ends with _exit(130). mpirun
/// answers both with SIGTERM for all ranks. A second SIGINT ends the process at once.
///
/// Make it after PETSc has started, whose own handlers would take its place. The former handlers
/// come back afterwards.
class InterruptGuard {
 public:
  struct Leaving {
    /// Called once in a thread of its own when SIGINT or SIGTERM has come, while the program may
    /// still be deep in a task; cut off when the grace ends.
    std::function<void()> last_words{};
    std::chrono::milliseconds grace{350};
  };

  /// Forgets earlier requests. One at a time in a process. Nothing is ever given up.
  InterruptGuard();
  explicit InterruptGuard(Leaving leaving);
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

 private:
  void install();
  void watch();

  static constexpr std::array signals{SIGINT, SIGTERM, SIGUSR1};
  std::array<struct sigaction, signals.size()> former_{};
  Leaving leaving_;
  std::atomic<bool> ending_{false};
  std::thread last_words_;
  std::thread watcher_;
};

/// This process was asked to stop since the guard was made; false when there is no guard.
bool interrupt_requested();

}  // namespace carillon::mpi
