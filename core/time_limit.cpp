#include "core/time_limit.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/progress.hpp"

namespace carillon::core {

std::string TimeLimit::message() const {
  if (given_up && given_up()) return work + " was interrupted";
  return fmt::format("{} takes longer than the limit of {}", work,
                     seconds < 1 ? fmt::format("{:.3g} s", seconds) : human_duration(seconds));
}

std::string TimeLimit::hint() const {
  return given_up && given_up() ? "" : fmt::format("raise {}", key);
}

void TimeLimit::refuse() const {
  throw TimeError(message(), hint());
}

}  // namespace carillon::core
