#pragma once

#include <mpi.h>

#include <cstdint>
#include <vector>

namespace carillon::mpi {

/// Where the ranks of a run are, and what their nodes hold. Decides when a task begins, never what
/// it computes.
struct Machine {
  std::vector<int> node_of_rank{};     ///< for each rank; empty: one node without bounds
  std::vector<std::int64_t> memory{};  ///< [byte] for the tasks of each node together
  bool measured = false;  ///< that is what happened to be free on some node, nobody's word
};

/// Ranks that share memory are a node's (MPI_Comm_split_type).
///
/// @param memory_per_node  [byte] for all that the ranks of a node take; 0: what is free now, by
///                         /proc/meminfo, the control groups (files that are kept in memory count
///                         as free) and Slurm's SLURM_MEM_PER_NODE or SLURM_MEM_PER_CPU, whichever
///                         leaves least
/// @return the same on every rank; what the ranks hold already is taken off
/// @note Collective on world.
Machine describe_machine(MPI_Comm world, std::int64_t memory_per_node);

/// Who holds how much of the nodes' memory while tasks run. A group's ranks hold equal shares of
/// its task. Knows no MPI.
class MemoryLedger {
 public:
  explicit MemoryLedger(Machine machine = {});

  /// Whether the ranks [first, first + width) can hold a task of so many bytes: beside what runs
  /// now, or with their nodes to themselves.
  bool fits(double bytes, int width, int first) const { return fits(bytes, width, first, held_); }
  bool fits_alone(double bytes, int width, int first) const;
  /// A task begins, or has ended.
  void take(double bytes, int width, int first) { move(bytes, width, first, 1); }
  void give_back(double bytes, int width, int first) { move(bytes, width, first, -1); }

  bool bounded() const { return !machine_.node_of_rank.empty(); }
  const Machine& machine() const { return machine_; }
  /// [byte] held on each node.
  const std::vector<std::int64_t>& held() const { return held_; }

 private:
  bool fits(double bytes, int width, int first, const std::vector<std::int64_t>& held) const;
  void move(double bytes, int width, int first, std::int64_t sign);

  Machine machine_;
  std::vector<std::int64_t> held_;
};

}  // namespace carillon::mpi
