#pragma once

#include <functional>
#include <string>

#include "core/trace.hpp"

namespace carillon::core {

/// How long a piece of work may take, counted from when this object is made, and whether anyone
/// still waits for it. For work that looks at it now and then; it can only end the work, never
/// change what comes out.
struct TimeLimit {
  double seconds = 0;  ///< wall clock; 0: none
  std::string work;    ///< what takes the time, e.g. "the solve"
  std::string key;     ///< where the limit was set, e.g. "limits.solve_time"
  double start = monotonic_seconds();
  std::function<bool()> given_up{};  ///< nobody waits any more; empty: somebody always does

  /// Whether it may ever pass.
  bool is_set() const { return seconds > 0 || given_up; }
  bool passed() const {
    return (given_up && given_up()) || (seconds > 0 && monotonic_seconds() - start > seconds);
  }
  /// The same words whenever and wherever it is noticed.
  std::string message() const;
  std::string hint() const;
  /// @throws TimeError
  [[noreturn]] void refuse() const;
};

}  // namespace carillon::core
