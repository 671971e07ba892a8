#include "dataset/exporters/whole_dataset.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <set>

#include "core/error.hpp"
#include "core/files.hpp"
#include "dataset/stored/shared_rows.hpp"
#include "dataset/stored/stored_dataset.hpp"
#include "mpi/folder_lock.hpp"

namespace carillon::dataset::exporters {

namespace fs = std::filesystem;

namespace {

/// A variant of a sweep is built under the sweep's lock.
bool is_at_work(const fs::path& folder) {
  const fs::path sweep = core::tidy_path(fs::absolute(folder)).parent_path();
  return mpi::is_locked(folder) || (fs::exists(sweep / "sweep.json") && mpi::is_locked(sweep));
}

void add_missing(const fs::path& folder, const core::Hdf5Group& group, const std::string& array,
                 std::set<std::string>& missing) {
  if (!group.has(array) || group.is_group(array)) return;
  for (const core::VirtualSource& source : group.virtual_sources(array)) {
    if (!fs::exists(folder / source.file)) missing.insert(source.file);
  }
}

void warn_of_fewer(const fs::path& folder, std::size_t samples) {
  try {
    const std::size_t planned = stored::open_dataset(folder, "").build.plan.samples.size();
    if (samples < planned) {
      spdlog::warn(
          "{} has {} of {} planned samples: failures.json says what failed, and the build goes on "
          "when it is run again",
          folder.string(), samples, planned);
    }
  } catch (const std::exception& error) {  // what is there can be exported all the same
    spdlog::warn("{}: how many samples were planned is not known: {}", folder.string(),
                 error.what());
  }
}

}  // namespace

void require_whole(const fs::path& folder, const core::Hdf5Group& index,
                   const std::vector<std::string>& arrays) {
  if (is_at_work(folder)) {
    throw core::InputError(
        fmt::format("a build, a training or an evaluation is at work in {}", folder.string()),
        "wait for its end");
  }
  std::set<std::string> missing;
  add_missing(folder, index, "audio", missing);
  for (const std::string& array : arrays) {
    const std::string path = stored::find_array(index, array).path;
    if (!path.empty()) add_missing(folder, index, path, missing);
  }
  if (!missing.empty()) {
    std::vector<std::string> named(missing.begin(), missing.end());
    constexpr std::size_t max_named = 5;
    if (named.size() > max_named) {
      named.resize(max_named);
      named.push_back(fmt::format("{} more", missing.size() - max_named));
    }
    throw core::InputError(
        fmt::format("{} lacks files: {}", folder.string(), fmt::join(named, ", ")),
        "put them back, or run the build again into this folder: it makes them anew");
  }
  if (index.has("key")) warn_of_fewer(folder, index.extent("key").front());
}

}  // namespace carillon::dataset::exporters
