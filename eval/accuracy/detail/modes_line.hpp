#pragma once

#include <string>

#include "eval/accuracy/accuracy_config.hpp"
#include "solvers/modes/modes.hpp"

namespace carillon::eval::accuracy {

/// The command that refines an object to a target as the study does: the same band, number of modes
/// and bound on elements. For a shell.
/// @return "" for a turned profile, which has no form on the command line
std::string modes_line(const StudiedObject& object, const solvers::modes::Band& band,
                       std::int64_t max_elements, double cents);

}  // namespace carillon::eval::accuracy
