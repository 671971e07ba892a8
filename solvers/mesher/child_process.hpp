#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace carillon::solvers::mesher {

/// How a child process ended.
struct ChildExit {
  int code = 0;            ///< exit code, when `signal` is 0
  int signal = 0;          ///< that ended it
  bool timed_out = false;  ///< it was killed at the time limit
  double seconds = 0;      ///< it ran
  std::string output;      ///< the end of what it printed, both streams, at most 4 KiB
};

/// Runs a program and waits for it. Started by posix_spawn, which is safe beside MPI's threads and
/// pinned memory; it inherits no descriptors, has a process group of its own and blocks SIGINT,
/// SIGTERM and SIGUSR1, so that Ctrl-C in the terminal and a batch system's signals are the
/// caller's to answer.
///
/// @param seconds  wall-clock limit, then SIGKILL; 0 or less: none
/// @throws StorageError  it cannot be started
ChildExit run_child(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                    double seconds);

}  // namespace carillon::solvers::mesher
