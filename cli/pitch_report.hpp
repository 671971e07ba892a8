#pragma once

#include <optional>

#include "cli/context.hpp"
#include "solvers/pitch_target.hpp"

namespace carillon::cli {

/// A target that was asked for and not met: a warning, and the exit code that says so.
void settle(const std::optional<solvers::PitchReport>& report, Context& context);

/// What was tried, and how it ended, for a person.
void print_report(const solvers::PitchReport& report);

}  // namespace carillon::cli
