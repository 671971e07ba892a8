#include "dataset/run/check_files.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>

#include "core/error.hpp"
#include "core/hash.hpp"

namespace carillon::dataset::run {

using nlohmann::json;

std::string damage_of(const std::filesystem::path& path, const ListedFile& listed, bool read_it) {
  std::error_code error;
  const auto bytes = std::filesystem::file_size(path, error);
  if (error) {
    return error == std::errc::no_such_file_or_directory ? "is missing"
                                                         : "cannot be read: " + error.message();
  }
  if (bytes != listed.bytes) {
    return fmt::format("has {} bytes instead of {}", bytes, listed.bytes);
  }
  if (!read_it) return {};
  try {
    if (core::sha256_file(path) == listed.sha256) return {};
    return "has changed (its SHA-256 is not the listed one)";
  } catch (const core::FileError& failure) {
    return "cannot be read: " + failure.message();
  }
}

std::int64_t modified_ns(const std::filesystem::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return 0;
  return std::int64_t{status.st_mtim.tv_sec} * 1000000000 + status.st_mtim.tv_nsec;
}

namespace {

std::vector<ListedFile> files_of(const json& entry) {
  return entry.value("files", std::vector<ListedFile>{});
}

}  // namespace

void drop_damaged(std::map<std::string, json>& entries, const std::filesystem::path& output) {
  constexpr int max_lines = 20;
  std::uint64_t total = 0;
  for (const auto& [task, entry] : entries) {
    for (const ListedFile& file : files_of(entry)) total += file.bytes;
  }
  int damaged = 0;
  std::erase_if(entries, [&](const auto& item) {
    const json& entry = item.second;
    const std::vector<ListedFile> files = files_of(entry);
    const json times = entry.value("modified_ns", json::array());
    bool whole = true;
    for (std::size_t i = 0; i < files.size(); ++i) {
      const std::string& name = files[i].path;
      const std::int64_t modified = i < times.size() ? times[i].template get<std::int64_t>() : 0;
      const bool read_it = total <= read_always_bytes || modified != modified_ns(output / name);
      const std::string what = damage_of(output / name, files[i], read_it);
      if (what.empty()) continue;
      whole = false;
      if (++damaged <= max_lines) {
        spdlog::warn("{} {}: {} runs again", (output / name).string(), what, item.first);
      }
    }
    return !whole;
  });
  if (damaged > max_lines) {
    spdlog::warn("{}: {} more files are missing or damaged: their tasks run again", output.string(),
                 damaged - max_lines);
  }
}

}  // namespace carillon::dataset::run
