#pragma once

#include <mpi.h>

#include <string>

namespace carillon::mpi {

/// What every command gets: the world's ranks and the options before the command's name.
struct Context {
  MPI_Comm world = MPI_COMM_NULL;    ///< null for a command that needs no ranks and has none
  char* const* arguments = nullptr;  ///< of main(), null at the end
  bool json = false;                 ///< one JSON document on standard output instead of text
  bool quiet = false;                ///< no progress lines
  std::string cache;                 ///< folder of meshes and modes; empty: none is kept
  std::string command;               ///< as it was typed, for files that say what made them
  int exit_code = 0;                 ///< what the command ends with when it throws nothing

  /// Rank 0 speaks for all, also before MPI has started.
  bool speaks() const;
};

/// Exit codes of the program.
enum ExitCode {
  exit_done = 0,
  exit_internal = 1,
  exit_input = 2,     ///< usage, configuration, input, or a body that cannot be solved as asked
  exit_failures = 3,  ///< finished, but tasks failed or a pitch target was not met
  exit_interrupted = 130,
  exit_overdue = 152  ///< a task went on after its limit of time; as a shell tells SIGXCPU
};

}  // namespace carillon::mpi
