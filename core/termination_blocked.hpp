#pragma once

#include <csignal>

namespace carillon::core {

/// While one lives, SIGTERM does not reach this thread. Threads that it starts meanwhile never hear
/// of one: all but the main thread are started so, and where the main thread cannot be disturbed, a
/// signal waits for it instead of ending up in another.
class TerminationBlocked {
 public:
  TerminationBlocked() {
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &set, &former_);
  }
  ~TerminationBlocked() { pthread_sigmask(SIG_SETMASK, &former_, nullptr); }
  TerminationBlocked(const TerminationBlocked&) = delete;
  TerminationBlocked& operator=(const TerminationBlocked&) = delete;

 private:
  sigset_t former_{};
};

}  // namespace carillon::core
