#pragma once

#include <mpi.h>

#include <map>
#include <span>
#include <string>
#include <vector>

#include "cli/build/build.hpp"

namespace carillon::cli {

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
  FindMeshes of(const BuildConfig& config) const;

 private:
  std::map<std::string, std::vector<FoundMesh>> by_key_;
};

}  // namespace carillon::cli
