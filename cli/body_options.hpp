#pragma once

#include <string>

#include "scene/body.hpp"

namespace carillon::cli {

class Command;

/// Adds the options of a body to a command.
void add_body_options(Command& command, scene::BodyOptions& options);

/// Three numbers with units, "0.1,0,2 cm".
/// @throws InputError
Vec3 parse_position(const std::string& text);

}  // namespace carillon::cli
