#pragma once

#include <cstdint>

#include "core/config.hpp"

namespace carillon::dataset::configuration {

/// How a build uses its ranks.
struct RanksConfig {
  double unknowns_per_rank = 300000;  ///< an object expected to have more is solved by a group
  int widest_group = 64;              ///< ranks
  std::int64_t memory_per_node = 0;   ///< [byte] for all ranks of a node; 0: what is free
};

/// Reads `ranks:`.
/// @throws ConfigError
RanksConfig read_ranks(core::ConfigNode node);

/// Without what only says when a task may begin, so that a build can go on on another machine.
/// @param resolved  a configuration as core::ConfigNode::resolved() gives it
std::string without_machine(const std::string& resolved);

/// Ranks that solve an object: 1 up to unknowns_per_rank; above, the power of two that leaves each
/// no more than that, up to widest_group. Depends on nothing else, so that neither the number of
/// ranks nor their memory decides how an object is solved, unless there are fewer ranks than this.
int group_width(const RanksConfig& ranks, double unknowns);

}  // namespace carillon::dataset::configuration
