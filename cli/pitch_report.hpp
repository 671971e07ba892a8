#pragma once

#include <optional>

#include "cli/context.hpp"
#include "cli/object_options.hpp"
#include "solvers/pitch/pitch_target.hpp"

namespace carillon::cli {

/// A target that was not met: a warning, and where the options asked for it the exit code that says
/// so.
void settle(const ObjectOptions& options, const std::optional<solvers::pitch::PitchReport>& report,
            Context& context);

/// What was tried, and how it ended, for a person.
void print_report(const solvers::pitch::PitchReport& report);

}  // namespace carillon::cli
