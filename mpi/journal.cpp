#include "mpi/journal.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <string_view>
#include <system_error>

#include "core/files.hpp"
#include "core/storage_error.hpp"

namespace carillon::mpi {

namespace {

std::string system_reason() {
  return std::generic_category().message(errno);
}

/// A new name in a folder is durable when the folder is synced.
bool sync_folder(const std::filesystem::path& folder) {
  const int handle = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (handle < 0) return false;
  const bool synced = fsync(handle) == 0;
  close(handle);
  return synced;
}

bool write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = write(file, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace

JournalLines read_journal(const std::filesystem::path& path) {
  const std::string text = core::read_file(path);
  JournalLines lines;
  std::size_t begin = 0;
  for (std::size_t number = 1; begin < text.size(); ++number) {
    const std::size_t end = text.find('\n', begin);
    // The newline is written last: a line without one was never finished, nor its task recorded.
    if (end == std::string::npos) break;
    nlohmann::json entry =
        nlohmann::json::parse(text.begin() + static_cast<std::ptrdiff_t>(begin),
                              text.begin() + static_cast<std::ptrdiff_t>(end), nullptr, false);
    if (entry.is_object()) {
      lines.entries.push_back(std::move(entry));
      lines.text.append(text, begin, end + 1 - begin);
    } else {
      lines.damaged.push_back(number);
    }
    begin = end + 1;
  }
  return lines;
}

Journal::Journal(std::filesystem::path path) : path_(std::move(path)) {
  const std::filesystem::path folder = path_.has_parent_path() ? path_.parent_path() : ".";
  std::error_code ignored;  // open() says it better
  std::filesystem::create_directories(folder, ignored);
  const bool is_new = !std::filesystem::exists(path_, ignored);
  open_file();
  try {
    if (is_new && !sync_folder(folder)) fail("cannot be synced");
    JournalLines lines = read_journal(path_);
    repair(lines);
    entries_ = std::move(lines.entries);
  } catch (...) {
    close(file_);
    throw;
  }
}

void Journal::open_file() {
  file_ = open(path_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (file_ < 0) fail("cannot be opened");
}

Journal::~Journal() {
  close(file_);
}

void Journal::fail(const char* what) const {
  throw core::StorageError(fmt::format("{}: {}: {}", path_.string(), what, system_reason()),
                           "make room or give the right to write there, and run the same command "
                           "again: what is finished is kept");
}

void Journal::repair(const JournalLines& lines) {
  for (const std::size_t number : lines.damaged) {
    spdlog::warn("{}:{} was damaged: the task that it recorded runs again", path_.string(), number);
  }
  if (!lines.damaged.empty()) {
    core::write_text_durably(path_, lines.text);
    close(file_);
    open_file();
    return;
  }
  const auto whole = static_cast<off_t>(lines.text.size());
  const off_t end = lseek(file_, 0, SEEK_END);
  if (end < 0 || (end > whole && (ftruncate(file_, whole) != 0 || fdatasync(file_) != 0))) {
    fail("its cut last line cannot be removed");
  }
}

void Journal::append(const nlohmann::json& entry) {
  if (!entry.is_object()) throw core::Error("an entry of the journal must be a JSON object");
  const std::string line =
      entry.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
  const off_t before = lseek(file_, 0, SEEK_END);
  if (before < 0) fail("cannot be written");
  if (write_all(file_, line) && fdatasync(file_) == 0) return;
  const int error = errno;
  // Half a line would spoil the next one.
  const bool restored = ftruncate(file_, before) == 0;
  errno = error;
  fail(restored ? "cannot be written" : "cannot be written and ends in half a line");
}

}  // namespace carillon::mpi
