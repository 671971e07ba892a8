#include "cli/play/interrupt.hpp"

#include <pthread.h>

#include <array>
#include <csignal>

namespace carillon::cli::play {

namespace {

constexpr std::array noted_signals = {SIGINT, SIGTERM, SIGHUP, SIGQUIT};
volatile std::sig_atomic_t noted = 0;
std::array<struct sigaction, noted_signals.size() + 1> previous_actions;

void note(int signal) {
  noted = signal;
}

}  // namespace

Interrupts::Interrupts() {
  noted = 0;
  struct sigaction action {};
  action.sa_handler = note;  // no SA_RESTART: what waits comes back
  sigemptyset(&action.sa_mask);
  for (std::size_t i = 0; i < noted_signals.size(); ++i) {
    sigaction(noted_signals[i], &action, &previous_actions[i]);
  }
  action.sa_handler = SIG_IGN;
  sigaction(SIGPIPE, &action, &previous_actions.back());
}

Interrupts::~Interrupts() {
  for (std::size_t i = 0; i < noted_signals.size(); ++i) {
    sigaction(noted_signals[i], &previous_actions[i], nullptr);
  }
  sigaction(SIGPIPE, &previous_actions.back(), nullptr);
}

int Interrupts::signal() {
  return noted;
}

void block_signals_here() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : noted_signals) sigaddset(&set, signal);
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
}

}  // namespace carillon::cli::play
