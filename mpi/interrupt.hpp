#pragma once

#include <signal.h>

#include <array>

namespace carillon::mpi {

/// While one lives, SIGINT, SIGTERM and SIGUSR1 ask the program to stop instead of ending it: the
/// tasks that run are finished, no new ones begin. A second SIGINT ends the process at once. The
/// former handlers come back afterwards.
///
/// Make it after PETSc has started, whose own handlers would take its place. Open MPI's mpirun
/// answers Ctrl-C and SIGTERM with SIGTERM for all ranks after a second and SIGKILL after another
/// (`--mca odls_base_sigkill_timeout SECONDS` sets both): a longer task is cut, and begins anew in
/// the next run. SIGUSR1 sent to mpirun is passed on to the ranks and nothing is killed, so every
/// task can end; batch systems send it before time is up (`sbatch --signal=B:USR1@120`).
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
