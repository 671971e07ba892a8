#pragma once

#include <filesystem>

namespace carillon::dataset::exporters {

/// The folder that an export fills. One that an export before left unfinished is emptied first.
class ExportFolder {
 public:
  /// Makes the folder and marks it as unfinished.
  /// @throws InputError  it holds something else; FileError  it cannot be made
  static void begin(const std::filesystem::path& path);
  /// Takes the mark away.
  static void finish(const std::filesystem::path& path);
};

}  // namespace carillon::dataset::exporters
