#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/what_is.hpp"
#include "report/report.hpp"

namespace carillon::report {

namespace fs = std::filesystem;

namespace {

constexpr int deepest = 4;

/// Folders of a dataset that hold no other.
const std::set<std::string> own_folders = {"cache",    "inputs",  "modes",   "movies",
                                           "pictures", "running", "samples", "sounds"};

/// @param seen  folders that were looked in, which may be named twice
/// @throws filesystem_error  the folder cannot be read
void look_in(const fs::path& folder, int depth, std::set<fs::path>& seen, ReportFolders& found) {
  if (!seen.insert(fs::canonical(folder)).second) return;
  const auto holds = [&](const char* name) { return fs::is_regular_file(folder / name); };
  if (holds("dataset.json")) found.datasets.push_back(folder);
  if (holds("status.json")) found.builds.push_back(folder);
  if (holds("sweep.json")) found.sweeps.push_back(folder);
  if (holds("accuracy.json")) found.studies.push_back(folder);
  if (holds("nightly.json")) found.nightly_runs.push_back(folder);
  if (fs::is_directory(folder / "evaluation")) found.evaluations.push_back(folder / "evaluation");
  if (depth == 0) return;
  std::vector<fs::path> below;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    std::error_code unknown;  // of links that lead nowhere
    if (entry.is_directory(unknown) && !own_folders.contains(name) && name != "evaluation" &&
        !name.starts_with('.')) {
      below.push_back(entry.path());
    }
  }
  std::sort(below.begin(), below.end());
  for (const fs::path& path : below) {
    try {
      look_in(path, depth - 1, seen, found);
    } catch (const fs::filesystem_error& error) {
      found.unreadable.push_back(
          fmt::format("{} cannot be looked into: {}", path.string(), error.code().message()));
    }
  }
}

}  // namespace

ReportFolders find_report_folders(const std::vector<std::string>& folders, bool may_be_empty) {
  ReportFolders found;
  std::set<fs::path> seen;
  for (const std::string& folder : folders) {
    if (!fs::is_directory(folder)) {
      const core::WhatIs what = core::what_is(folder);
      throw core::InputError(
          what.name == "missing"
              ? fmt::format("{}: no such folder", folder)
              : fmt::format("{} is {}, and a folder is wanted", folder, what.name),
          "name folders that build, accuracy or evaluate made");
    }
    try {
      look_in(core::tidy_path(folder), deepest, seen, found);
    } catch (const fs::filesystem_error& error) {
      throw core::InputError(
          fmt::format("{} cannot be looked into: {}", folder, error.code().message()),
          "name folders that you may read");
    }
  }
  if (!may_be_empty && found.datasets.empty() && found.builds.empty() && found.studies.empty() &&
      found.nightly_runs.empty() && found.evaluations.empty()) {
    throw core::InputError(
        fmt::format("{}: nothing to report, neither datasets nor accuracy.json nor evaluations",
                    fmt::join(folders, ", ")),
        "name folders that build, accuracy or evaluate made");
  }
  return found;
}

}  // namespace carillon::report
