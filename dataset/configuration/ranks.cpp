#include "dataset/configuration/ranks.hpp"

#include "core/text.hpp"

namespace carillon::dataset::configuration {

using core::ConfigNode;
using core::Dimension;

RanksConfig read_ranks(ConfigNode node) {
  RanksConfig ranks;
  ranks.unknowns_per_rank = static_cast<double>(node.integer(
      "unknowns_per_rank", 1000, 1000000000, static_cast<std::int64_t>(ranks.unknowns_per_rank)));
  ranks.widest_group = static_cast<int>(node.integer("widest_group", 1, 4096, ranks.widest_group));
  const double bytes = node.quantity("memory_per_node", Dimension::memory, 0);
  if (bytes != 0) {
    core::at_key(node, "memory_per_node",
                 [&] { ranks.memory_per_node = core::whole_bytes(bytes); });
  }
  return ranks;
}

std::string without_machine(const std::string& resolved) {
  const std::size_t key = resolved.find("\n  memory_per_node: ");
  if (key == std::string::npos) return resolved;
  std::string text = resolved;
  return text.erase(key + 1, text.find('\n', key + 1) - key);
}

int group_width(const RanksConfig& ranks, double unknowns) {
  int width = 1;
  while (width < ranks.widest_group && unknowns > width * ranks.unknowns_per_rank) width *= 2;
  return std::min(width, ranks.widest_group);
}

}  // namespace carillon::dataset::configuration
