#include <cmath>
#include <map>

#include "mpi/machine.hpp"

namespace carillon::mpi {

namespace {

/// [byte] of each rank of a task. Whole numbers, so that what is taken and given back leaves
/// nothing behind.
std::int64_t share_of(double bytes, int width) {
  return static_cast<std::int64_t>(std::ceil(bytes / width));
}

/// [byte] that a task asks of each node its ranks are on.
std::map<int, std::int64_t> shares(const Machine& machine, double bytes, int width, int first) {
  std::map<int, std::int64_t> of_node;
  const std::int64_t share = share_of(bytes, width);
  for (int rank = first; rank < first + width; ++rank) {
    of_node[machine.node_of_rank.at(static_cast<std::size_t>(rank))] += share;
  }
  return of_node;
}

std::size_t node_of(const Machine& machine, int rank) {
  return static_cast<std::size_t>(machine.node_of_rank.at(static_cast<std::size_t>(rank)));
}

}  // namespace

MemoryLedger::MemoryLedger(Machine machine)
    : machine_(std::move(machine)), held_(machine_.memory.size(), 0) {}

// Most tasks are of one rank, and the host asks this many times a second: no map for them.
bool MemoryLedger::fits_alone(double bytes, int width, int first) const {
  if (bounded() && width == 1)
    return share_of(bytes, 1) <= machine_.memory[node_of(machine_, first)];
  return fits(bytes, width, first, std::vector<std::int64_t>(held_.size(), 0));
}

bool MemoryLedger::fits(double bytes, int width, int first,
                        const std::vector<std::int64_t>& held) const {
  if (!bounded()) return true;
  if (width == 1) {
    const std::size_t n = node_of(machine_, first);
    return held[n] + share_of(bytes, 1) <= machine_.memory[n];
  }
  for (const auto& [node, share] : shares(machine_, bytes, width, first)) {
    const auto n = static_cast<std::size_t>(node);
    if (held[n] + share > machine_.memory[n]) return false;
  }
  return true;
}

void MemoryLedger::move(double bytes, int width, int first, std::int64_t sign) {
  if (!bounded()) return;
  for (const auto& [node, share] : shares(machine_, bytes, width, first)) {
    held_[static_cast<std::size_t>(node)] += sign * share;
  }
}

}  // namespace carillon::mpi
