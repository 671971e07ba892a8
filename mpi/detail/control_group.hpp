#pragma once

#include <cstdint>
#include <filesystem>

namespace carillon::mpi {

/// [byte] that the control groups of this process (Linux, version 1 or 2), its own and all above,
/// still leave: limit less use, where pages of files that can be dropped count as free. The largest
/// number there is where none has a limit.
/// @param root  of the file tree with /proc and /sys
std::int64_t memory_left_in_groups(const std::filesystem::path& root = "/");

}  // namespace carillon::mpi
