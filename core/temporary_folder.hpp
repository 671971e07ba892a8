#pragma once

#include <filesystem>

namespace carillon::core {

/// A folder among the system's temporary files ($TMPDIR) that goes with this object. The first that
/// a process makes removes those that killed processes left more than a day ago.
class TemporaryFolder {
 public:
  /// @throws StorageError  none can be made
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::filesystem::path& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
  int entry_ = -1;  ///< among those that remove_temporary_folders() knows
};

/// Removes those of this process that are there, for a program that ends at once. A signal handler
/// may call it.
void remove_temporary_folders() noexcept;

}  // namespace carillon::core
