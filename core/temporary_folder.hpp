#pragma once

#include <filesystem>

namespace carillon::core {

/// A folder among the system's temporary files that goes with this object.
class TemporaryFolder {
 public:
  /// @throws FileError  none can be made
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace carillon::core
