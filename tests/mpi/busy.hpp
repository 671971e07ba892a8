#pragma once

#include <sys/resource.h>

#include <chrono>
#include <thread>

#include "core/trace.hpp"

namespace carillon::mpi {

/// Computes, without a call to MPI or a rest.
inline void compute_for(double seconds) {
  const double end = core::monotonic_seconds() + seconds;
  while (core::monotonic_seconds() < end) {
  }
}

inline void sleep_for(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

/// Processor time of all threads of this process [s].
inline double processor_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

}  // namespace carillon::mpi
