#pragma once

#include <mpi.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

namespace carillon::mpi {

/// What is done, one line of JSON per finished task, appended and synced after the task's files
/// are in place. Written by one process only.
class Journal {
 public:
  explicit Journal(std::filesystem::path path);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  /// Lines of earlier runs; a last line cut short by a crash is ignored and removed.
  const std::vector<nlohmann::json>& entries() const { return entries_; }
  void append(const nlohmann::json& entry);

 private:
  std::filesystem::path path_;
  int file_ = -1;
  std::vector<nlohmann::json> entries_;
};

/// Holds an output folder for one build: every process of it keeps a lock that dies with the
/// process (flock), so a second build is refused while any rank of the first is alive.
class FolderLock {
 public:
  /// Rank 0 takes it, the others join.
  /// @throws core::FileError  another build holds it, on every rank alike
  /// @note Collective on comm.
  FolderLock(const std::filesystem::path& folder, MPI_Comm comm);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_ = -1;
};

}  // namespace carillon::mpi
