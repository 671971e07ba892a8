#include "core/temporary_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <limits.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdint>
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

/// Folders that are there. A signal handler reads it: no memory is given back, nothing is locked.
struct Entry {
  std::atomic<bool> taken{false}, whole{false};
  std::array<char, PATH_MAX> path{};
};
std::array<Entry, 16> entries;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may touch nothing else");

/// @return the number of the entry; -1: all are taken
int enter(const std::string& path) {
  if (path.size() >= PATH_MAX) return -1;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (entries[i].taken.exchange(true)) continue;
    std::copy_n(path.c_str(), path.size() + 1, entries[i].path.begin());
    entries[i].whole.store(true);
    return static_cast<int>(i);
  }
  return -1;
}

/// Linux' directory entries, as getdents64(2) gives them: readdir may ask for memory.
struct LinuxEntry {
  std::uint64_t inode;
  std::int64_t offset;
  unsigned short length;
  unsigned char type;
  char name[];
};

void remove_tree(int parent, const char* name, int deepest) noexcept;

void remove_entries(int folder, int deepest) noexcept {
  alignas(LinuxEntry) std::array<char, 4096> block;
  for (long size = 0; (size = ::syscall(SYS_getdents64, folder, block.data(), block.size())) > 0;) {
    for (long at = 0; at < size;) {
      const auto* entry = reinterpret_cast<const LinuxEntry*>(block.data() + at);
      at += entry->length;
      const char* file = entry->name;
      if (std::strcmp(file, ".") == 0 || std::strcmp(file, "..") == 0) continue;
      if (::unlinkat(folder, file, 0) != 0 && deepest > 0) remove_tree(folder, file, deepest - 1);
    }
  }
}

void remove_tree(int parent, const char* name, int deepest) noexcept {
  // Another process may put one more file there while others go.
  for (int attempt = 0; attempt < 3; ++attempt) {
    const int folder = ::openat(parent, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (folder < 0) return;
    remove_entries(folder, deepest);
    ::close(folder);
    if (::unlinkat(parent, name, AT_REMOVEDIR) == 0 || errno != ENOTEMPTY) return;
  }
}

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
  entry_ = enter(name);
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  if (entry_ < 0) return;
  entries[static_cast<std::size_t>(entry_)].whole.store(false);
  entries[static_cast<std::size_t>(entry_)].taken.store(false);
}

void remove_temporary_folders() noexcept {
  constexpr int deepest = 8;
  for (const Entry& entry : entries) {
    if (entry.whole.load()) remove_tree(AT_FDCWD, entry.path.data(), deepest);
  }
}

}  // namespace carillon::core
