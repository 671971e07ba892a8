#pragma once

namespace carillon::mpi {

/// What the processors have done for a thread so far.
struct WorkClock {
  double cpu = 0;     ///< [s] computing: this thread but for what it spins in MPI (waiting.hpp),
                      ///< and the child processes it has waited for
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
