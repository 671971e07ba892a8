#pragma once

#include <optional>

#include "cli/context.hpp"
#include "solvers/pitch/pitch_target.hpp"

namespace carillon::cli {

/// A target that was asked for and not met: a warning, and the exit code that says so.
void settle(const std::optional<solvers::pitch::PitchReport>& report, Context& context);

/// What was tried, and how it ended, for a person.
void print_report(const solvers::pitch::PitchReport& report);

}  // namespace carillon::cli
