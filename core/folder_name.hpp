#pragma once

#include <string>

#include "core/config.hpp"

namespace carillon::core {

/// What a configuration makes is called by its key `name`, else by the file's own name, and so is
/// the folder that it is made in: letters, digits, - _ and . are in it, and it begins with none of
/// - and `.`, so that it lies where the program runs.
/// @throws ConfigError  at the key
std::string folder_name(ConfigNode& root, const std::string& file_name);

}  // namespace carillon::core
