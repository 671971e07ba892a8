#include "dataset/exporters/export_folder.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/files.hpp"

namespace carillon::dataset::exporters {

namespace fs = std::filesystem;

namespace {

constexpr const char* mark = ".unfinished-export";

}  // namespace

void ExportFolder::begin(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (!fs::is_directory(path)) {
    throw core::FileError(fmt::format("{}: no folder can be made: {}", path.string(),
                                      error ? error.message() : "something else is there"));
  }
  if (!fs::is_empty(path) && !fs::exists(path / mark)) {
    throw core::InputError(fmt::format("{} is not empty", path.string()),
                           "give --output a new folder, or delete this one");
  }
  // What an export left unfinished may be another's, of other parts or sizes: it goes. The mark
  // stays until the end, so that a stop here leaves nothing that looks finished.
  core::write_text_durably(path / mark, "");
  for (const auto& entry : fs::directory_iterator(path)) {
    if (entry.path().filename() != mark) fs::remove_all(entry.path());
  }
}

void ExportFolder::finish(const fs::path& path) {
  fs::remove(path / mark);
}

}  // namespace carillon::dataset::exporters
