#pragma once

namespace carillon::mpi {

/// What the processors have done for a thread so far.
struct WorkClock {
  double cpu = 0;     ///< [s] of processors: this thread, and the child processes it has waited
                      ///< for. Waiting within mpi/ sleeps and takes none; PETSc's and MUMPS' own
                      ///< calls of MPI spin while they wait for a group's other ranks, which counts
  double queued = 0;  ///< [s] this thread was ready and others had the processor; 0 where the
                      ///< system does not tell

  WorkClock operator-(const WorkClock& earlier) const {
    return {cpu - earlier.cpu, queued - earlier.queued};
  }
};

/// Of the calling thread, now.
WorkClock work_clock();

/// Most memory that this process ever held [byte].
double peak_memory();

}  // namespace carillon::mpi
