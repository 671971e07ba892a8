#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace carillon::mpi {

/// The task that a rank is busy with: noted in a file that outlives the process however it ends,
/// and ended together with the process when it hangs. The task's line is on the disk before its
/// work begins, and gone when the work has ended or the process has been asked to stop
/// (interrupt.hpp).
class RunningTask {
 public:
  /// @param file       this rank's own; removed at a clean end, its folder too by whoever is last;
  ///                   "" for none
  /// @param exit_code  of the process that it ends
  /// @throws core::FileError
  RunningTask(std::filesystem::path file, int exit_code);
  ~RunningTask();
  RunningTask(const RunningTask&) = delete;
  RunningTask& operator=(const RunningTask&) = delete;

  void begin(const std::string& task);
  /// A part of it begins.
  /// @param item     what the part is busy with; may be empty
  /// @param seconds  after which the process is ended with `words`, on standard error and in the
  ///                 file: for work that cannot be stopped otherwise. 0: never
  void enter(const std::string& stage, const std::string& item, double seconds,
             const std::string& words);
  void end();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A task that was begun and has not ended: its process is gone.
struct BegunTask {
  std::string task;
  std::string stage;    ///< part of the task; may be empty
  std::string item;     ///< what that part was busy with; may be empty
  std::string overdue;  ///< why its process ended itself; empty where it did not
  std::string file;     ///< name of the file it was noted in
};

/// What is left in a folder of such files, in the order of their names; what cannot be read tells
/// nothing.
std::vector<BegunTask> begun_tasks(const std::filesystem::path& folder);

}  // namespace carillon::mpi
