#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

namespace carillon::dataset::run {

/// Up to this many bytes, every file of a folder is read again when a build goes on.
constexpr std::uint64_t read_always_bytes = std::uint64_t{1} << 30;

/// A file as journal and dataset.json list it.
struct ListedFile {
  std::string path{};  ///< from the dataset's folder
  std::string sha256{};
  std::uint64_t bytes = 0;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ListedFile, path, sha256, bytes)

/// What is wrong with a file: "is missing", "has 3 bytes instead of 4", "cannot be read: ..."; ""
/// for nothing.
/// @param read_it  compares its contents too
std::string damage_of(const std::filesystem::path& path, const ListedFile& listed,
                      bool read_it = true);

/// Takes out the entries whose files are missing, of another size or of other contents, so that
/// their tasks run again; one line on standard error for each such file says what and why.
///
/// Sizes are compared always. Contents (SHA-256) are compared where the time of the last change is
/// not the journal's, and of all files while they are at most read_always_bytes together, which
/// takes some seconds. (`carillon check` reads everything.)
void drop_damaged(std::map<std::string, nlohmann::json>& entries,
                  const std::filesystem::path& output);

/// Time of a file's last change [ns], for the journal.
std::int64_t modified_ns(const std::filesystem::path& file);

}  // namespace carillon::dataset::run
