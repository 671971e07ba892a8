#include "core/temporary_folder.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "core/storage_error.hpp"

namespace carillon::core {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view prefix = "carillon-of-";

constexpr const char* temporary_hint =
    "make room, or set TMPDIR to a folder that may be written to, on every node; then run the same "
    "command again";

/// Removes the folders of processes that were killed more than a day ago: nobody else will.
void remove_dead() {
  std::error_code error;
  std::vector<fs::path> dead;
  for (fs::directory_iterator at(fs::temp_directory_path(error), error), end; !error && at != end;
       at.increment(error)) {
    const std::string name = at->path().filename().string();
    if (!name.starts_with(prefix)) continue;
    const pid_t process = std::atoi(name.c_str() + prefix.size());
    const bool ended = process > 0 && ::kill(process, 0) != 0 && errno == ESRCH;
    std::error_code unknown;
    const auto written = fs::last_write_time(at->path(), unknown);
    if (ended && !unknown && fs::file_time_type::clock::now() - written > std::chrono::hours(24)) {
      dead.push_back(at->path());
    }
  }
  for (const fs::path& folder : dead) fs::remove_all(folder, error);
}

}  // namespace

TemporaryFolder::TemporaryFolder() {
  static const bool cleaned = (remove_dead(), true);
  static_cast<void>(cleaned);
  std::error_code error;
  const fs::path folder = fs::temp_directory_path(error);
  if (error) {
    const char* named = std::getenv("TMPDIR");
    throw StorageError(
        fmt::format("{} is no folder for temporary files", named != nullptr ? named : "/tmp"),
        temporary_hint);
  }
  std::string name = (folder / fmt::format("{}{}-XXXXXX", prefix, ::getpid())).string();
  if (::mkdtemp(name.data()) == nullptr) {
    throw StorageError(fmt::format("{}: no folder can be made there for temporary files: {}",
                                   folder.string(), std::strerror(errno)),
                       temporary_hint);
  }
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

}  // namespace carillon::core
