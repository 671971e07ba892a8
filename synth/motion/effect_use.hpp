#pragma once

#include <chrono>
#include <cstdint>

namespace carillon::synth::motion {

/// What a part of the sound cost: a trace of what ran.
struct EffectUse {
  std::uint64_t calls = 0;
  double seconds = 0;
};

/// Adds the time since its making to a part's seconds.
class Stopwatch {
 public:
  explicit Stopwatch(EffectUse& use) : use_(use), begin_(std::chrono::steady_clock::now()) {}
  ~Stopwatch() {
    use_.seconds +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  EffectUse& use_;
  std::chrono::steady_clock::time_point begin_;
};

}  // namespace carillon::synth::motion
