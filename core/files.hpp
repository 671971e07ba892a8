#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace carillon::core {

/// Writes through `write(temporary_path)`, syncs the file, renames it to `path` and syncs the
/// folder: after a crash the file is there whole or not at all. Missing folders are made.
/// @throws StorageError  naming the path and the system's reason; nothing is left behind
void write_durably(const std::filesystem::path& path,
                   const std::function<void(const std::filesystem::path&)>& write);

/// The same for a text or any bytes that are at hand.
void write_text_durably(const std::filesystem::path& path, std::string_view text);

/// Removes what writers that were killed left in a folder and the folders in it: the temporary
/// files of write_durably.
/// @param alone  nobody else writes there: all of them go; else those of processes of this host
///               that have ended, ten minutes after the last write
/// @return how many
int remove_leftovers(const std::filesystem::path& folder, bool alone);

/// @throws FileError
std::string read_file(const std::filesystem::path& path);

/// The same for large files: `take` gets the bytes in order, block by block.
/// @throws FileError
void read_blocks(const std::filesystem::path& path,
                 const std::function<void(std::string_view)>& take);

/// A path as it is named: without `.`, doubled separators or one at its end, which completion adds.
std::filesystem::path tidy_path(const std::filesystem::path& path);

/// Files that match a pattern with *, ? and [..] (glob(3)), in byte order of their names; a
/// leading ~ is the home folder, ** as a folder stands for any number of them, none too. Folders
/// are left out, and links to folders are not followed by **.
/// @throws FileError  out of memory, or the system cannot search
std::vector<std::filesystem::path> glob_files(const std::string& pattern);

/// Folder for results that can be computed again: $CARILLON_CACHE, else
/// $XDG_CACHE_HOME/carillon, else ~/.cache/carillon.
std::filesystem::path default_cache_folder();

}  // namespace carillon::core
