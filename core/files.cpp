#include "core/files.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <glob.h>
#include <pwd.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <regex>
#include <set>
#include <system_error>

#include "core/handle.hpp"
#include "core/host_name.hpp"
#include "core/storage_error.hpp"

namespace carillon::core {

namespace fs = std::filesystem;

namespace {

constexpr const char* storage_hint =
    "make room or give the right to write there, and run the same command again: what is finished "
    "is kept";

void close_descriptor(int* descriptor) {
  ::close(*descriptor);
}
using Descriptor = Handle<int, close_descriptor, -1>;

[[noreturn]] void fail(const fs::path& path, std::string_view doing, int error) {
  throw FileError(
      fmt::format("{}: {}: {}", path.string(), doing, std::generic_category().message(error)));
}

Descriptor open_or_fail(const fs::path& path, int flags, std::string_view doing) {
  Descriptor file(::open(path.c_str(), flags | O_CLOEXEC));
  if (file.get() < 0) fail(path, doing, errno);
  return file;
}

void sync(const fs::path& path, int flags) {
  const Descriptor file = open_or_fail(path, O_RDONLY | flags, "cannot be synced");
  // Some file systems cannot sync a folder and say so with EINVAL; there is nothing left to do.
  if (::fsync(file.get()) != 0 && errno != EINVAL) fail(path, "cannot be synced", errno);
}

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

/// Makes a folder and those above it, each synced into the one that holds it.
void make_folder(const fs::path& folder) {
  std::error_code error;
  if (fs::is_directory(folder, error)) return;
  const fs::path above = folder_of(folder);
  if (above != folder) make_folder(above);
  fs::create_directory(folder, error);
  // Another rank may have made it meanwhile; only what stands there now counts.
  if (!fs::is_directory(folder)) {
    fail(folder, "the folder cannot be made", fs::exists(folder) ? ENOTDIR : error.value());
  }
  sync(above, O_DIRECTORY);
}

/// A name beside `path` that no other process, thread or host writes to. The ending stays, as
/// writers choose the format by it.
fs::path temporary_beside(const fs::path& path) {
  static std::atomic<unsigned> count = 0;
  const std::string name = fmt::format(".{}.{}.{}.{}.tmp{}", path.stem().string().substr(0, 100),
                                       host_name(), ::getpid(), count++, path.extension().string());
  return folder_of(path) / name;
}

/// Whether a name is one that temporary_beside makes; `process` gets whose, where it is of this
/// host, else 0.
bool is_temporary(const std::string& name, pid_t& process) {
  static const std::regex form(R"((\..*)\.([0-9]{1,9})\.[0-9]+\.tmp(\.[^.]*)?)");
  std::smatch parts;
  if (!std::regex_match(name, parts, form)) return false;
  process = parts[1].str().ends_with(fmt::format(".{}", host_name())) ? std::stoi(parts[2]) : 0;
  return true;
}

/// Old enough that no process of another container under the same host name is at it.
bool is_old(const fs::path& file) {
  std::error_code error;
  const auto written = fs::last_write_time(file, error);
  return !error && fs::file_time_type::clock::now() - written > std::chrono::minutes(10);
}

/// Why writing failed, in the system's words. HDF5 hides the number in its own.
std::string storage_reason(const FileError& error, const fs::path& path) {
  const std::string& text = error.message();
  static const std::regex number("errno = ([0-9]+)");
  std::smatch found;
  if (std::regex_search(text, found, number)) {
    return fmt::format("{}: cannot be written: {}", path.string(),
                       std::generic_category().message(std::stoi(found[1])));
  }
  return text.starts_with(path.string()) ? text : fmt::format("{}: {}", path.string(), text);
}

struct Removal {
  const fs::path& path;
  bool armed = true;
  ~Removal() {
    std::error_code ignored;
    if (armed) fs::remove(path, ignored);
  }
};

/// The variable's value; one that is empty counts as not set.
std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

}  // namespace

void write_durably(const fs::path& path, const std::function<void(const fs::path&)>& write) {
  if (fs::is_directory(path)) fail(path, "cannot be written", EISDIR);  // no want of room
  try {
    make_folder(folder_of(path));
    const fs::path temporary = temporary_beside(path);
    Removal removal{temporary};
    write(temporary);
    sync(temporary, 0);
    if (::rename(temporary.c_str(), path.c_str()) != 0) fail(path, "cannot be written", errno);
    removal.armed = false;
    sync(folder_of(path), O_DIRECTORY);
  } catch (const StorageError&) {
    throw;
  } catch (const FileError& error) {
    throw StorageError(storage_reason(error, path), storage_hint);
  } catch (const fs::filesystem_error& error) {
    throw StorageError(
        fmt::format("{}: cannot be written: {}", path.string(), error.code().message()),
        storage_hint);
  }
}

void write_text_durably(const fs::path& path, std::string_view text) {
  write_durably(path, [&path, text](const fs::path& temporary) {
    const Descriptor file(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (file.get() < 0) fail(path, "cannot be written", errno);
    for (std::string_view rest = text; !rest.empty();) {
      const ssize_t written = ::write(file.get(), rest.data(), rest.size());
      if (written < 0 && errno != EINTR) fail(path, "cannot be written", errno);
      if (written > 0) rest.remove_prefix(static_cast<std::size_t>(written));
    }
  });
}

int remove_leftovers(const fs::path& folder, bool alone) {
  std::vector<fs::path> found;
  std::error_code error;
  const auto options = fs::directory_options::skip_permission_denied;
  for (fs::recursive_directory_iterator at(folder, options, error), end; !error && at != end;
       at.increment(error)) {
    pid_t process = 0;
    if (!is_temporary(at->path().filename().string(), process)) continue;
    const auto ended = [&] {
      return process > 0 && ::kill(process, 0) != 0 && errno == ESRCH && is_old(at->path());
    };
    if (alone || ended()) found.push_back(at->path());
  }
  int removed = 0;
  for (const fs::path& file : found) removed += fs::remove(file, error) ? 1 : 0;
  return removed;
}

void read_blocks(const fs::path& path, const std::function<void(std::string_view)>& take) {
  const Descriptor file = open_or_fail(path, O_RDONLY, "cannot be read");
  std::string block(std::size_t{1} << 16, '\0');
  while (true) {
    const ssize_t count = ::read(file.get(), block.data(), block.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail(path, "cannot be read", errno);
    if (count == 0) return;
    take(std::string_view(block.data(), static_cast<std::size_t>(count)));
  }
}

std::string read_file(const fs::path& path) {
  std::string text;
  read_blocks(path, [&](std::string_view block) { text += block; });
  return text;
}

fs::path tidy_path(const fs::path& path) {
  const fs::path tidy = path.lexically_normal();
  return tidy.has_filename() || !tidy.has_relative_path() ? tidy : tidy.parent_path();
}

namespace {

/// Paths that the C library's glob finds, folders too.
std::vector<fs::path> glob_paths(const std::string& pattern) {
  glob_t found{};
  struct Release {
    glob_t* list;
    ~Release() { ::globfree(list); }
  } release{&found};
  const int outcome = ::glob(pattern.c_str(), GLOB_NOSORT | GLOB_TILDE, nullptr, &found);
  if (outcome == GLOB_NOMATCH) return {};
  if (outcome != 0) {
    throw FileError(fmt::format("{}: cannot be searched: {}", pattern,
                                outcome == GLOB_NOSPACE ? "out of memory" : "reading failed"));
  }
  return {found.gl_pathv, found.gl_pathv + found.gl_pathc};
}

/// The folders below one, and itself.
std::vector<fs::path> folders_below(const fs::path& folder) {
  std::vector<fs::path> folders = {folder};
  std::error_code error;
  const auto options = fs::directory_options::skip_permission_denied;
  for (auto entry = fs::recursive_directory_iterator(folder, options, error);
       !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    std::error_code ignored;
    if (entry->is_directory(ignored)) folders.push_back(entry->path());
  }
  return folders;
}

/// A folder's name as a pattern that matches it alone.
std::string escaped(const fs::path& folder) {
  std::string text;
  for (const char c : folder.string()) {
    if (std::string_view("*?[\\").find(c) != std::string_view::npos) text += '\\';
    text += c;
  }
  return text;
}

}  // namespace

std::vector<fs::path> glob_files(const std::string& pattern) {
  std::set<fs::path> files;
  const std::size_t deep = ("/" + pattern).find("/**/");
  if (deep == std::string::npos) {
    for (const fs::path& path : glob_paths(pattern)) {
      std::error_code ignored;
      if (!fs::is_directory(path, ignored)) files.insert(path);
    }
  } else {
    const std::string above = pattern.substr(0, deep), below = pattern.substr(deep + 3);
    for (const fs::path& start : glob_paths(above.empty() ? "./" : above)) {
      for (const fs::path& folder : folders_below(start))
        for (const fs::path& file : glob_files(escaped(folder) + "/" + below)) files.insert(file);
    }
  }
  // glob's own order follows the locale.
  std::vector<fs::path> sorted(files.begin(), files.end());
  std::sort(sorted.begin(), sorted.end(),
            [](const fs::path& a, const fs::path& b) { return a.native() < b.native(); });
  return sorted;
}

fs::path default_cache_folder() {
  if (const std::string folder = environment("CARILLON_CACHE"); !folder.empty()) return folder;
  // The XDG base directory specification has relative paths ignored.
  if (const fs::path base = environment("XDG_CACHE_HOME"); base.is_absolute()) {
    return base / "carillon";
  }
  fs::path home = environment("HOME");
  if (home.empty()) {
    const passwd* user = ::getpwuid(::getuid());
    home = user != nullptr && user->pw_dir != nullptr ? fs::path(user->pw_dir)
                                                      : fs::temp_directory_path();
  }
  return home / ".cache" / "carillon";
}

}  // namespace carillon::core
