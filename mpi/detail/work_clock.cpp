#include "mpi/detail/work_clock.hpp"

#include <sys/resource.h>
#include <time.h>

#include <fstream>

#include "core/trace.hpp"

namespace carillon::mpi {

namespace {

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

}  // namespace

WorkClock work_clock() {
  rusage children{};
  getrusage(RUSAGE_CHILDREN, &children);
  WorkClock clock;
  clock.cpu =
      core::thread_cpu_seconds() + seconds_of(children.ru_utime) + seconds_of(children.ru_stime);
  // Nanoseconds on a processor, and in the queue for one.
  std::ifstream schedule("/proc/thread-self/schedstat");
  double ran = 0, queued = 0;
  if (schedule >> ran >> queued) clock.queued = 1e-9 * queued;
  return clock;
}

double peak_memory() {
  rusage own{};
  getrusage(RUSAGE_SELF, &own);
  return 1024.0 * static_cast<double>(own.ru_maxrss);
}

}  // namespace carillon::mpi
