#pragma once

#include <mpi.h>

#include <map>
#include <span>
#include <string>
#include <vector>

#include "dataset/plan/identities.hpp"
#include "dataset/run/build.hpp"

namespace carillon::dataset::run {

/// Mesh files of builds, by the entry of `objects:` that finds them.
class SharedMeshes {
 public:
  /// Looks the files of all builds up on rank 0 and reads each once: the ranks share the reading,
  /// and every rank has what was found.
  /// @throws FileError   on every rank alike
  /// @throws InputError  likewise: a rank sees other files than the others
  /// @note Collective on world.
  SharedMeshes(std::span<const LoadedBuild> builds, MPI_Comm world);

  /// For make_plan() of one of the builds; both must outlive it.
  plan::FindMeshes of(const configuration::BuildConfig& config) const;

 private:
  std::map<std::string, std::vector<plan::FoundFile>> by_key_;
};

}  // namespace carillon::dataset::run
