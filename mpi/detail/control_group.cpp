#include "mpi/detail/control_group.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <string_view>
#include <vector>

namespace carillon::mpi {

namespace {

namespace fs = std::filesystem;

constexpr std::int64_t unbounded = std::numeric_limits<std::int64_t>::max();

/// How a version names its files of memory.
struct Names {
  const char *limit, *used, *inactive, *active;
};
constexpr Names version_1{"memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file",
                          "total_active_file"};
constexpr Names version_2{"memory.max", "memory.current", "inactive_file", "active_file"};

/// The number in a file of one line; unbounded where there is none ("max").
std::int64_t number_in(const fs::path& path) {
  std::ifstream file(path);
  std::int64_t number = 0;
  return file >> number ? number : unbounded;
}

/// A number of a file with a name and a number in each line; `missing` where it is not there.
std::int64_t number_of(const fs::path& path, std::string_view name, std::int64_t missing) {
  std::ifstream file(path);
  std::string word;
  for (std::int64_t number = 0; file >> word >> number;) {
    if (word == name) return number;
  }
  return missing;
}

/// A group and all above it, which a container may not show under the same names.
std::vector<fs::path> with_those_above(const fs::path& mount, std::string group) {
  std::vector<fs::path> folders;
  while (!group.empty()) {
    if (group != "/") folders.push_back(mount / group.substr(1));
    group.resize(group.rfind('/'));
  }
  folders.push_back(mount);
  return folders;
}

/// This process's groups that count memory, innermost first.
struct Groups {
  std::vector<fs::path> folders{};
  const Names* names = nullptr;
};

std::vector<Groups> groups_of_memory(const fs::path& root) {
  std::vector<Groups> all;
  std::ifstream file(root / "proc/self/cgroup");
  // number:controllers:/group, where version 2 has number 0 and names none
  for (std::string line; std::getline(file, line);) {
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos || line.size() < second + 2 || line[second + 1] != '/')
      continue;
    const std::string group = line.substr(second + 1);
    const std::string controllers = fmt::format(",{},", line.substr(first + 1, second - first - 1));
    if (line.starts_with("0::")) {
      all.push_back({with_those_above(root / "sys/fs/cgroup", group), &version_2});
    } else if (controllers.find(",memory,") != std::string::npos) {
      all.push_back({with_those_above(root / "sys/fs/cgroup/memory", group), &version_1});
    }
  }
  return all;
}

std::int64_t left_in(const fs::path& group, const Names& names) {
  const std::int64_t maximum = number_in(group / names.limit);
  const std::int64_t used = number_in(group / names.used);
  if (maximum == unbounded || used == unbounded) return unbounded;
  const fs::path stat = group / "memory.stat";
  const std::int64_t files = number_of(stat, names.inactive, 0) + number_of(stat, names.active, 0);
  return maximum - std::max<std::int64_t>(used - files, 0);
}

}  // namespace

std::int64_t memory_left_in_groups(const fs::path& root) {
  std::int64_t left = unbounded;
  for (const Groups& groups : groups_of_memory(root)) {
    for (const fs::path& folder : groups.folders) {
      left = std::min(left, left_in(folder, *groups.names));
    }
  }
  return left;
}

}  // namespace carillon::mpi
