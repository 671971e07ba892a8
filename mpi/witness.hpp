#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "mpi/host.hpp"

namespace carillon::mpi {

/// What is known of a process that has gone while it ran a task.
struct Testimony {
  std::string process;  ///< unique: host, process number and start
  int ranks = 1;        ///< of the run
  std::string task;
  std::string stage;          ///< part of the task; may be empty
  std::string item;           ///< what that part was busy with; may be empty
  Host host;                  ///< as it was when the task began
  std::int64_t resident = 0;  ///< [byte] in RAM, half a second before the end at the latest

  enum class End {
    silent,   ///< not a word: SIGKILL by somebody or by a kernel out of memory, power cut, _exit()
    stopped,  ///< it had been asked to stop (SIGINT, SIGTERM, SIGUSR1)
    crashed,  ///< `words` is the signal's name
    overdue,  ///< it ended itself since the task took too long; `words` says so
  } end = End::silent;
  std::string words;
};

/// Tells what its rank is doing, in a file that outlives the process however it ends, and ends the
/// process when a task hangs. A file costs some microseconds for each part of a task; nothing is
/// synced, so that a power cut leaves none.
class Witness {
 public:
  /// @param file       written from here on, and removed at a clean end; "" for none
  /// @param ranks      of the run
  /// @param exit_code  of the process that it ends
  /// @throws core::FileError
  Witness(std::filesystem::path file, int ranks, int exit_code);
  ~Witness();
  Witness(const Witness&) = delete;
  Witness& operator=(const Witness&) = delete;

  /// A task begins. Between tasks there is nothing to tell.
  void begin(const std::string& task);
  /// Another part of it begins.
  /// @param seconds  after which the process is ended with `words`, on standard error and in the
  ///                 file: for work that cannot be stopped otherwise. 0: never
  void enter(const std::string& stage, const std::string& item, double seconds,
             const std::string& words);
  void end();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Every file of a folder that tells of a task; what cannot be read tells nothing.
std::vector<Testimony> read_testimonies(const std::filesystem::path& folder);

}  // namespace carillon::mpi
