#include <cmath>
#include <map>

#include "mpi/machine.hpp"

namespace carillon::mpi {

namespace {

/// [byte] that a task asks of each node its ranks are on. Whole numbers, so that what is taken and
/// given back leaves nothing behind.
std::map<int, std::int64_t> shares(const Machine& machine, double bytes, int width, int first) {
  std::map<int, std::int64_t> of_node;
  const auto share = static_cast<std::int64_t>(std::ceil(bytes / width));
  for (int rank = first; rank < first + width; ++rank) {
    of_node[machine.node_of_rank.at(static_cast<std::size_t>(rank))] += share;
  }
  return of_node;
}

}  // namespace

MemoryLedger::MemoryLedger(Machine machine)
    : machine_(std::move(machine)), held_(machine_.memory.size(), 0) {}

bool MemoryLedger::fits_alone(double bytes, int width, int first) const {
  return fits(bytes, width, first, std::vector<std::int64_t>(held_.size(), 0));
}

bool MemoryLedger::fits(double bytes, int width, int first,
                        const std::vector<std::int64_t>& held) const {
  if (!bounded()) return true;
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
