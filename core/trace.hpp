#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>

namespace carillon::core {

/// Calls and seconds of each stage and effect that ran, gathered by the code that runs them and
/// merged over ranks at the end.
struct Trace {
  struct Entry {
    std::int64_t calls = 0;
    double seconds = 0;
    bool operator==(const Entry&) const = default;
  };
  std::map<std::string, Entry> stages;
  std::map<std::string, Entry> effects;
  /// Told when another part of a task begins, and what it is busy with ("" for all of it); may be
  /// empty. Parts: mesh, solve, sound, write.
  std::function<void(const std::string& part, const std::string& item)> on_enter{};

  void enter(const std::string& part, const std::string& item = {}) const {
    if (on_enter) on_enter(part, item);
  }

  void merge(const Trace& other);
};

/// Adds one call and the time between construction and destruction to an entry.
class ScopedTimer {
 public:
  explicit ScopedTimer(Trace::Entry& entry);
  ~ScopedTimer();
  ScopedTimer(const ScopedTimer&) = delete;
  ScopedTimer& operator=(const ScopedTimer&) = delete;

 private:
  Trace::Entry& entry_;
  double start_;
};

/// Seconds on a monotonic clock.
double monotonic_seconds();
/// Processor time of the calling thread [s].
double thread_cpu_seconds();

}  // namespace carillon::core
