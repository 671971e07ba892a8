#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "mpi/folder_lock.hpp"

namespace carillon::mpi {

/// The finished lines of a journal; a last line without its end is still being written, or was cut
/// by a crash, and is no part of it.
struct JournalLines {
  std::vector<nlohmann::json> entries;  ///< of the lines that are JSON objects
  std::string text;                     ///< of these lines
  std::vector<std::size_t> damaged;     ///< numbers of the other lines, from 1
};

/// Reads only: another process may be writing to the file.
/// @throws core::FileError  it cannot be read
JournalLines read_journal(const std::filesystem::path& path);

/// What is done, one JSON object a line, appended and synced after the task's files are in place.
/// Written by one process only, which holds the folder's lock; several threads take turns by
/// themselves (the service's hooks do).
class Journal {
 public:
  /// Opens the file, or makes it and its folder. Lines that are no JSON object are taken out of the
  /// file, with a warning: what they recorded counts as not done.
  /// @throws core::FileError  with the system's reason
  explicit Journal(std::filesystem::path path);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  /// Lines of earlier runs; a last line cut short by a crash is ignored and removed.
  const std::vector<nlohmann::json>& entries() const { return entries_; }

  /// The entry is on the disk when this returns. Text that is not UTF-8 is replaced.
  /// @throws core::Error         the entry is not an object
  /// @throws core::StorageError  it could not be written (disk full); then no part of it stays
  void append(const nlohmann::json& entry);

 private:
  void open_file();
  void repair(const JournalLines& lines);
  [[noreturn]] void fail(const char* what) const;

  std::filesystem::path path_;
  int file_ = -1;
  std::vector<nlohmann::json> entries_;
};

}  // namespace carillon::mpi
