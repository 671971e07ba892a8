#include "core/trace.hpp"

#include <time.h>

#include <chrono>

namespace carillon::core {

namespace {

void add(std::map<std::string, Trace::Entry>& into,
         const std::map<std::string, Trace::Entry>& from) {
  for (const auto& [name, entry] : from) {
    Trace::Entry& sum = into[name];
    sum.calls += entry.calls;
    sum.seconds += entry.seconds;
  }
}

}  // namespace

void Trace::merge(const Trace& other) {
  add(stages, other.stages);
  add(effects, other.effects);
}

ScopedTimer::ScopedTimer(Trace::Entry& entry) : entry_(entry), start_(monotonic_seconds()) {}

ScopedTimer::~ScopedTimer() {
  entry_.calls += 1;
  entry_.seconds += monotonic_seconds() - start_;
}

double monotonic_seconds() {
  const auto since = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(since).count();
}

double thread_cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace carillon::core
