#pragma once

#include <mpi.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace carillon::dataset::run {

/// File in which a rank notes the task that it runs (mpi/running_task.hpp), in a folder that is
/// there while a build runs and stays behind when it is killed.
std::filesystem::path running_file(const std::filesystem::path& output, int rank);
/// The rank whose file is called so; -1 for another's.
int rank_of_running_file(const std::string& name);

/// A build whose tasks earlier runs may have tried.
struct AttemptedBuild {
  std::string name;  ///< before its tasks' keys in the ranks' files
  std::filesystem::path journal;
  /// Hash of what decides a task (TaskInputs), by its key; "" for tasks of no plan.
  std::function<std::string(const std::string&)> inputs_of;
};

/// Keys of a build's tasks that were begun by earlier runs and have not ended.
struct Attempts {
  std::vector<std::string> given_up;  ///< just now: not even this run should try them again
  std::vector<std::string> open;      ///< to be tried again
};

/// Before the board is made: a task that an earlier run had begun when it ended, other than by
/// being asked to stop, has an attempt more in its journal. After two attempts without an outcome
/// it is given up, and after one in which it went on after its time limit: an ordinary failed
/// outcome.
/// @return by build, on rank 0
/// @note Collective on world; rank 0 reads and writes.
std::vector<Attempts> settle_attempts(const std::filesystem::path& output,
                                      const std::vector<AttemptedBuild>& builds, MPI_Comm world);

}  // namespace carillon::dataset::run
