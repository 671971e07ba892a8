#pragma once

#include <span>

#include "mpi/task_board.hpp"

namespace carillon::mpi {

/// The ranks that run a schedule.
struct SimulatedRanks {
  int ranks = 1;
  int ranks_per_node = 1;        ///< neighbours that share a memory
  std::int64_t node_memory = 0;  ///< of each node for tasks [byte]; 0: without bounds
};

/// How a schedule went. Times begin with the first task.
struct Schedule {
  double makespan = 0;    ///< until the last task has ended [s]
  double task_time = 0;   ///< ranks times seconds inside tasks [s]
  double efficiency = 1;  ///< task_time over ranks times makespan
  /// No schedule is shorter than either of these [s]: the work shared by all ranks, and the longest
  /// chain of tasks that wait for each other.
  double shared_work = 0;
  double longest_chain = 0;
  /// After this moment the ranks are never all at work again [s].
  double all_at_work_until = 0;
  /// After this moment fewer than half of them are: stragglers dominate [s].
  double half_at_work_until = 0;
  std::int64_t last_task = -1;  ///< the one that ended last; -1: there is none
  double node_memory = 0;       ///< the most that tasks of one node's ranks held at a time [byte]
  std::int64_t refused = 0;     ///< tasks not run: no node has their memory, or they wait for such
  double idle = 0;              ///< of all ranks, waiting for tasks or for the end [s]
  /// Of it, waits that began while a task of the rank's width was ready and found no memory [s].
  double memory_wait = 0;
};

/// Plays a run_tasks() of `board` on so many ranks, by list scheduling: the board itself says who
/// does what, a group asks as soon as it is free, and asking takes no time. An event costs O(log
/// n), and where memory is bounded one look at each node that has waiting ranks. Estimates are
/// corrected as tasks end, as in a run.
///
/// @param board    tasks that are done already cost nothing
/// @param seconds  of each task on its group; for all tasks of the board
/// @throws core::Error  fewer than one rank, or rank of a node; memory below 0; seconds that are
///                      missing, negative or not finite
Schedule simulate(TaskBoard board, std::span<const double> seconds, const SimulatedRanks& on);

}  // namespace carillon::mpi
