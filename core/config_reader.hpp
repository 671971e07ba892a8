#pragma once

#include <string>

#include "core/config_tree.hpp"

namespace carillon::core {

/// One YAML document as a tree.
/// @param override_by  the `key=value` of a --set that holds the text; empty for a file
/// @throws ConfigError  text that is not UTF-8, malformed YAML, more than one document, a key twice
/// or one that is not a
///                      text, nesting or aliases without bound
ConfigTree read_yaml(const std::string& document, const std::string& file_name,
                     const std::string& override_by);

}  // namespace carillon::core
