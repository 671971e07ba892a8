#pragma once

#include "mpi/simulation.hpp"

namespace carillon::dataset::run {

/// What a build costs beside its tasks, whose estimates are those of board_tasks(), on the machine
/// of docs/scaling.md (a virtual machine of two cores). Each figure has the command that measures
/// it elsewhere.
struct MachineCosts {
  /// `scripts/bench schedule 4`: a question takes the host 5 us, a completed task 4.2 ms, nearly
  /// all of it the sync of its line in the journal; a host at rest answers after 4.5 ms. The last
  /// is the longest pause of TaskService::next.
  mpi::ServiceCosts service{
      .claim = 5e-6, .complete = 4.2e-3, .latency = 4.5e-3, .ask_again = 0.02};
  /// `time carillon build CONFIG` on a finished folder of 40 full shards, less the index:
  /// libraries, configuration, journal [s].
  double start = 0.7;
  /// `scripts/bench index DATASET`, the first writing, of full shards: a shard's rows of index.h5
  /// and dataset.json [s].
  double index_shard = 2.4e-3;
  /// `scripts/bench schedule`: a small file written durably, as each WAV file is [s].
  double file = 0.012;
};

}  // namespace carillon::dataset::run
