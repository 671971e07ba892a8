#pragma once

#include <span>

#include "mpi/task_board.hpp"

namespace carillon::mpi {

/// What the machinery around the tasks costs [s]. `scripts/bench schedule` measures the first
/// three.
struct ServiceCosts {
  double claim = 0;     ///< of the host, for each question for a task
  double complete = 0;  ///< of the host, for each completed task: its line in the journal, synced
  double latency = 0;   ///< between rank and host and back, the host's own time left out
  /// A rank that is told to wait asks again so much later (0: it is answered when there is
  /// something for it).
  double ask_again = 0;
};

/// The ranks that run a schedule.
struct SimulatedRanks {
  int ranks = 1;
  int ranks_per_node = 1;        ///< neighbours that share a memory
  std::int64_t node_memory = 0;  ///< of each node for tasks [byte]; 0: without bounds
};

/// How a schedule went. Times begin with the first question for a task.
struct Schedule {
  double makespan = 0;    ///< until the last rank has heard that there is nothing left [s]
  double task_time = 0;   ///< ranks times seconds inside tasks [s]
  double efficiency = 1;  ///< task_time over ranks times makespan
  /// No schedule is shorter than either of these [s]: the work shared by all ranks, and the longest
  /// chain of tasks that wait for each other.
  double shared_work = 0;
  double longest_chain = 0;
  /// After this moment the ranks are never all at work again, for want of tasks [s].
  double all_at_work_until = 0;
  /// After this moment fewer than half of them are: stragglers dominate [s].
  double half_at_work_until = 0;
  std::int64_t longest_task = -1;  ///< -1: there are none
  std::int64_t last_task = -1;     ///< the one that ended last
  double node_memory = 0;    ///< the most that tasks of one node's ranks held at a time [byte]
  std::int64_t refused = 0;  ///< tasks not run: no node has their memory, or they wait for such
  double idle = 0;           ///< of all ranks, waiting for tasks or for the end [s]
  /// Of it, waits that began while a task of the rank's width was ready and found no memory [s].
  double memory_wait = 0;

  // The service.
  double requests = 0;     ///< questions and completions that meant something
  double repeats = 0;      ///< questions of ranks that were told to wait
  double host_busy = 0;    ///< of the host's helper thread [s]
  double mean_answer = 0;  ///< time until a request is answered [s]
  double longest_answer = 0;
};

/// Plays a run_tasks() of `board` on so many ranks: the board itself says who does what, and a
/// queue of events in the order of time says when. The host answers one request after the other.
/// Each event costs O(log n), and where memory is bounded one look at each node that has waiting
/// ranks. Estimates are corrected as tasks end, as in a run, but by no more than the first thousand
/// of a kind, whose median changes little afterwards.
///
/// Ranks that wait are not followed one question at a time: the questions of P waiting ranks are
/// taken as evenly spread over `ask_again`, so the first of them finds a new task after a P + 1st
/// of it, and where the host cannot answer them in that time every request queues behind them.
///
/// @param board    tasks that are done already cost nothing
/// @param seconds  of each task on its group; for all tasks of the board
/// @throws core::Error  fewer than one rank, or rank of a node; memory below 0; seconds or costs
/// that are
///                      missing, negative or not finite
Schedule simulate(TaskBoard board, std::span<const double> seconds, const SimulatedRanks& on,
                  const ServiceCosts& costs = {});

}  // namespace carillon::mpi
