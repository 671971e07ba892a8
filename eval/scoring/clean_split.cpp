#include "eval/scoring/clean_split.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <fstream>
#include <vector>

#include "core/cached.hpp"
#include "core/error.hpp"
#include "core/hash.hpp"
#include "dataset/check/leaks.hpp"

namespace carillon::eval::scoring {

namespace {

namespace fs = std::filesystem;

/// Raised whenever what counts as a leak changes.
constexpr int verdict_version = 1;

/// Is there where the same dataset was found clean before; "" where that cannot be known. Names
/// what the verdict depends on: what was built, and by size and time that no file of it has changed
/// since (every build writes the index anew).
fs::path verdict_file(const fs::path& folder, const std::string& split, const fs::path& cache) {
  if (cache.empty()) return {};
  const fs::path description = folder / "dataset.json";
  if (!fs::is_regular_file(description) || !fs::is_regular_file(folder / "index.h5")) return {};
  std::vector<std::string> files;
  for (const char* place : {"modes", "samples"}) {
    if (!fs::is_directory(folder / place)) continue;
    for (const auto& entry : fs::directory_iterator(folder / place)) {
      files.push_back(fmt::format("{}/{}", place, entry.path().filename().string()));
    }
  }
  std::sort(files.begin(), files.end());
  std::string content =
      fmt::format("{} {} {} {}\n", verdict_version, split, core::sha256_file(description),
                  core::sha256_file(folder / "index.h5"));
  for (const std::string& file : files) {
    std::error_code missing;
    content += fmt::format("{} {} {}\n", file, fs::file_size(folder / file, missing),
                           fs::last_write_time(folder / file, missing).time_since_epoch().count());
  }
  return cache / "splits" / core::sha256(content);
}

}  // namespace

void require_clean_split(const fs::path& folder, const std::string& split, const fs::path& cache) {
  const fs::path verdict = verdict_file(folder, split, cache);
  if (!verdict.empty() && std::filesystem::exists(verdict)) return;
  const dataset::check::DatasetFolder opened = dataset::check::open_folder(folder, "");
  const std::vector<dataset::check::Row> rows = dataset::check::read_rows(opened, opened.present);
  const dataset::check::Finding findings[] = {
      split == "split_shape" ? dataset::check::check_split_shape(opened, rows)
                             : dataset::check::check_split_strike(opened, rows),
      dataset::check::check_rooms(rows), dataset::check::check_noise(rows)};
  for (const dataset::check::Finding& finding : findings) {
    if (finding.verdict != dataset::check::Verdict::fail) continue;
    throw core::InputError(
        fmt::format(
            "{}: {} leaks from one part into another: {}: {}", folder.string(), split, finding.text,
            fmt::join(finding.items.begin(),
                      finding.items.begin() + static_cast<std::ptrdiff_t>(
                                                  std::min<std::size_t>(3, finding.items.size())),
                      "; ")),
        "what is learnt from it would seem better than it is; carillon check tells all");
  }
  if (verdict.empty()) return;
  core::to_cache(verdict,
                 [](const std::filesystem::path& path) { std::ofstream(path) << "clean\n"; });
}

}  // namespace carillon::eval::scoring
