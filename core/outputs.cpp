#include "core/outputs.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>

#include "core/error.hpp"

namespace carillon::core {

namespace fs = std::filesystem;

namespace {

constexpr const char* output_hint = "name a place that may be written to";

[[noreturn]] void refuse(const fs::path& path, const std::string& why,
                         const std::string& hint = output_hint) {
  throw FileError(fmt::format("{}: cannot be written: {}", path.string(), why), hint);
}

/// A new file in a folder tells more than its permissions do, which are not asked for root, for
/// file systems that are read-only or made by the kernel.
void require_room(const fs::path& path, const fs::path& folder) {
  std::string name = (folder / ".carillon-XXXXXX").string();
  const int file = ::mkostemp(name.data(), O_CLOEXEC);
  if (file < 0) {
    refuse(path, fmt::format("no file can be made in {}: {}", folder.string(),
                             std::generic_category().message(errno)));
  }
  ::close(file);
  ::unlink(name.c_str());
}

/// The lowest folder above a path that is there already.
void require_place(const fs::path& path) {
  fs::path above = path.parent_path();
  std::error_code error;
  while (!above.empty() && !fs::exists(above, error)) {
    if (error) break;
    above = above.parent_path();
  }
  if (above.empty()) above = ".";
  if (!fs::is_directory(above, error)) {
    refuse(path, fmt::format("{} is no folder", above.string()));
  }
  require_room(path, above);
}

}  // namespace

void require_writable_file(const fs::path& path) {
  std::error_code error;
  if (path.empty()) refuse(path, "the name is empty", "name a file");
  if (fs::is_directory(path, error) || !path.has_filename()) {
    refuse(path, "it is a folder",
           fmt::format("name a file in it, as in {}", (path / "NAME").lexically_normal().string()));
  }
  const fs::file_status there = fs::status(path, error);
  // What is written is renamed, and would take a device's place.
  if (fs::exists(there) && !fs::is_regular_file(there)) refuse(path, "it is no regular file");
  require_place(path);
}

void require_writable_folder(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return require_room(path, path);
  if (fs::exists(path, error)) refuse(path, "it is a file, and a folder is wanted");
  require_place(path.has_filename() ? path : path.parent_path());
}

}  // namespace carillon::core
