#include "mpi/backoff.hpp"

#include <algorithm>
#include <thread>

namespace carillon::mpi {

void Backoff::pause() {
  if (yielded_ < yields_) {
    ++yielded_;
    std::this_thread::yield();
    return;
  }
  std::this_thread::sleep_for(rest_);
  rest_ = std::min(longest_, rest_ + rest_ / 2);
}

void Backoff::reset() {
  yielded_ = 0;
  rest_ = shortest;
}

bool wait_idly(MPI_Request& request, double seconds) {
  const auto begin = std::chrono::steady_clock::now();
  Backoff backoff;
  int finished = 0;
  for (;;) {
    MPI_Test(&request, &finished, MPI_STATUS_IGNORE);
    if (finished != 0) return true;
    const std::chrono::duration<double> waited = std::chrono::steady_clock::now() - begin;
    if (waited.count() > seconds) return false;
    backoff.pause();
  }
}

}  // namespace carillon::mpi
