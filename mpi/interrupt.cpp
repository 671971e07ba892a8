#include "mpi/interrupt.hpp"

#include <atomic>

namespace carillon::mpi {

namespace {

// The one variable of the process that a signal handler can reach.
std::atomic<bool> requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may touch nothing else");

extern "C" void request_interrupt(int) {
  requested.store(true);
}

}  // namespace

InterruptGuard::InterruptGuard() {
  requested.store(false);
  for (std::size_t i = 0; i < signals.size(); ++i) {
    struct sigaction action {};
    action.sa_handler = request_interrupt;
    sigemptyset(&action.sa_mask);
    // Calls that were under way go on. Only SIGINT comes from an impatient person twice; batch
    // systems may well send SIGTERM to mpirun and to its ranks.
    action.sa_flags = SA_RESTART;
    if (signals[i] == SIGINT) action.sa_flags |= static_cast<int>(SA_RESETHAND);
    sigaction(signals[i], &action, &former_[i]);
  }
}

InterruptGuard::~InterruptGuard() {
  for (std::size_t i = 0; i < signals.size(); ++i) sigaction(signals[i], &former_[i], nullptr);
  requested.store(false);
}

bool interrupt_requested() {
  return requested.load();
}

}  // namespace carillon::mpi
