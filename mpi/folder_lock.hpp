#pragma once

#include <mpi.h>

#include <filesystem>

namespace carillon::mpi {

/// Holds an output folder for one build: every process of it keeps a lock that dies with the
/// process (flock on `.lock` in the folder), so a second build is refused while any rank of the
/// first is alive. Child programs do not inherit it. The file stays behind; it means nothing by
/// itself. Where the file system has no locks, a warning says so and the build goes on.
class FolderLock {
 public:
  /// Rank 0 takes it, the others join. A missing folder is made.
  /// @param timeout_s  how long to wait for another build, as ranks of one that was killed take a
  ///                    moment to go; after a second of it a warning names who is waited for
  /// @throws core::FileError  another build holds it (the message names its processes and host), or
  ///                          the file cannot be locked; on every rank alike
  /// @note Collective on comm.
  FolderLock(const std::filesystem::path& folder, MPI_Comm comm, double timeout_s = 0);
  /// Gives up this rank's part.
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_ = -1;
};

/// Whether a build, a training or an evaluation holds a folder's lock; false where the file system
/// has no locks.
bool is_locked(const std::filesystem::path& folder);

}  // namespace carillon::mpi
