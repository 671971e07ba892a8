#pragma once

#include <mpi.h>

#include <chrono>
#include <limits>

namespace carillon::mpi {

/// How long to rest between two looks at something that has not happened yet: first only long
/// enough to let another process run, so that short waits stay short, then longer and longer, so
/// that long waits cost next to nothing even with more ranks than cores.
class Backoff {
 public:
  using Duration = std::chrono::microseconds;

  explicit Backoff(Duration longest = Duration(2000), int yields = 64)
      : longest_(longest), yields_(yields) {}

  void pause();
  /// Something happened: be quick again.
  void reset();

 private:
  static constexpr Duration shortest{50};
  Duration longest_;
  int yields_;
  int yielded_ = 0;
  Duration rest_ = shortest;
};

constexpr double endless = std::numeric_limits<double>::infinity();

/// Completes a request without holding a core meanwhile, unlike MPI_Wait.
/// @param seconds  after which it gives up
/// @return whether the request is complete
bool wait_idly(MPI_Request& request, double seconds = endless);

}  // namespace carillon::mpi
