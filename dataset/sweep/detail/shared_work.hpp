#pragma once

#include <map>
#include <string>
#include <vector>

#include "dataset/run/common_tasks.hpp"
#include "dataset/sweep/plan_sweep.hpp"

namespace carillon::dataset::sweep {

/// What a modes task computes and keeps in the cache. Tasks with an equal `mesh` begin with the
/// same mesh; those with equal `modes` solve the same.
struct SharedKeys {
  std::string mesh, modes;
  std::string mesh_limits;  ///< of its child process: who would fail by them
};

/// Names what modes tasks have in common; mesh files are read once.
class SharedWork {
 public:
  /// @throws FileError, InputError
  SharedKeys keys(const configuration::BuildConfig& config, const plan::Shape& shape);

 private:
  std::map<std::string, std::string> mesh_keys_;  ///< by request
};

/// Lets one modes task of each mesh and of each solve go first, of those that are not done; the
/// others wait until it has ended, well or not, and find its work in the cache. What only reads the
/// cache is cheap on the board, and of a kind of its own, "modes from cache".
/// @return those that would mesh or solve the same under the same limits as the first of them
run::SameWork order_shared_work(const std::vector<run::BuildRun>& builds, run::CommonTasks& common);

SharingCounts count_shared_work(const std::vector<run::LoadedBuild>& builds);

}  // namespace carillon::dataset::sweep
