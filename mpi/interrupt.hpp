#pragma once

#include <signal.h>

#include <array>

namespace carillon::mpi {

/// While one lives, SIGINT, SIGTERM and SIGUSR1 ask the program to stop instead of ending it: the
/// tasks that run are finished, no new ones begin. A second SIGINT ends the process at once. The
/// former handlers come back afterwards.
///
/// Make it after PETSc has started, whose own handlers would take its place. mpirun turns Ctrl-C
/// and SIGTERM into SIGTERM for all ranks and kills them a second later unless it is told to wait
/// (`--mca odls_base_sigkill_timeout SECONDS`); SIGUSR1 sent to mpirun is passed on and kills
/// nothing, and is what batch systems send before time is up (`sbatch --signal=USR1@120`).
class InterruptGuard {
 public:
  /// Forgets earlier requests. One at a time in a process.
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

 private:
  static constexpr std::array signals{SIGINT, SIGTERM, SIGUSR1};
  std::array<struct sigaction, signals.size()> former_{};
};

/// This process was asked to stop since the guard was made; false when there is no guard.
bool interrupt_requested();

}  // namespace carillon::mpi
