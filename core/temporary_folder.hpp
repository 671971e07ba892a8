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
};

}  // namespace carillon::core
