#pragma once

#include <thread>
#include <utility>

namespace carillon::cli::play {

/// While it lives, SIGINT, SIGTERM, SIGHUP and SIGQUIT are noted in place of ending the program,
/// and SIGPIPE is left to who writes.
class Interrupts {
 public:
  Interrupts();
  ~Interrupts();
  Interrupts(const Interrupts&) = delete;
  Interrupts& operator=(const Interrupts&) = delete;
  /// The signal that came; 0: none.
  static int signal();
};

/// Blocks the signals of Interrupts in the thread that calls it.
void block_signals_here();

/// A thread that these signals do not interrupt: the main one gets them.
template <class Work>
std::thread thread_without_signals(Work work) {
  return std::thread([work = std::move(work)]() mutable {
    block_signals_here();
    work();
  });
}

}  // namespace carillon::cli::play
