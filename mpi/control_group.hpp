#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace carillon::mpi {

/// [byte] that the control groups of this process (Linux, version 1 or 2), its own and all above,
/// still leave: limit less use, where pages of files that can be dropped count as free. The largest
/// number there is where none has a limit.
/// @param root  of the file tree with /proc and /sys
std::int64_t memory_left_in_groups(const std::filesystem::path& root = "/");

/// How often a group of processes has lost one for lack of memory.
struct GroupKills {
  std::string group{};      ///< which one, since when; "" where there is none that can be asked
  std::int64_t kills = -1;  ///< in it and all below it
};

/// Of the outermost control group with a limit of memory above this process: a job's or a
/// container's, which lives for several runs. Version 2 alone counts.
/// @param root  as above
GroupKills kills_in_group(const std::filesystem::path& root = "/");

}  // namespace carillon::mpi
