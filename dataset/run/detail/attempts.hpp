#pragma once

#include <mpi.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace carillon::dataset::run {

/// File in which a rank tells what it runs (mpi/witness.hpp), in a folder that is there while a
/// build runs and stays behind when it is killed.
std::filesystem::path witness_file(const std::filesystem::path& output, int rank);

/// A build whose tasks earlier runs may have tried.
struct AttemptedBuild {
  std::string name;  ///< before its tasks' keys in the words of witnesses
  std::filesystem::path journal;
  /// Hash of what decides a task (TaskInputs), by its key; "" for tasks of no plan.
  std::function<std::string(const std::string&)> inputs_of;
};

/// Before the board is made: reads what the ranks of an earlier run left behind in `output`, writes
/// into the journals whom it speaks against, and gives up the tasks that have ended too many runs:
///
/// - two by a crash or for lack of memory,
/// - one by going on after its time limit,
/// - ten in which its process alone ended without a word.
///
/// Counted from a task's last outcome in the journal on. Giving up is an ordinary failed outcome.
/// @return by build, the tasks given up just now, on rank 0: not even this run should try them
/// again
/// @note Collective on world; rank 0 reads and writes.
std::vector<std::vector<std::string>> settle_attempts(const std::filesystem::path& output,
                                                      const std::vector<AttemptedBuild>& builds,
                                                      MPI_Comm world);

}  // namespace carillon::dataset::run
