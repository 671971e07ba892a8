#pragma once

#include <sys/types.h>

#include <array>
#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace carillon::core {

/// A pipe to a child; what is written to end 1 is read from end 0. Its ends close with it.
class ChildPipe {
 public:
  /// @throws StorageError  too many files are open
  ChildPipe();
  ~ChildPipe();
  ChildPipe(const ChildPipe&) = delete;
  ChildPipe& operator=(const ChildPipe&) = delete;

  int end(std::size_t end) const { return ends_.at(end); }
  void close_end(std::size_t end);
  /// The end is the caller's to close.
  int take(std::size_t end) { return std::exchange(ends_.at(end), -1); }

 private:
  std::array<int, 2> ends_{-1, -1};
};

/// Descriptors that a child gets as its standard streams.
struct ChildStreams {
  int input = -1;  ///< -1: it reads nothing
  int output = 1;
  int error = 2;
};

/// Starts a program, which the caller waits for. By posix_spawn, which is safe beside threads and
/// MPI's pinned memory; it inherits no other descriptors, has a process group of its own and blocks
/// SIGINT, SIGTERM and SIGUSR1, so that Ctrl-C in the terminal and a batch system's signals are the
/// caller's to answer.
/// @param heeds_signals  it blocks none of them: the caller sends them itself
/// @return its process, which leads its group
/// @throws StorageError  it cannot be started
pid_t start_child(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                  const ChildStreams& streams, bool heeds_signals = false);

/// How a child process ended.
struct ChildExit {
  int code = 0;            ///< exit code, when `signal` is 0
  int signal = 0;          ///< that ended it
  bool timed_out = false;  ///< it was killed at the time limit
  double seconds = 0;      ///< it ran
  std::string output;      ///< the end of what it printed, both streams, at most 4 KiB
};

/// Runs a program as start_child() does, and waits for it.
///
/// @param seconds  wall-clock limit, then SIGKILL; 0 or less: none
/// @throws StorageError  it cannot be started
ChildExit run_child(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                    double seconds);

}  // namespace carillon::core
