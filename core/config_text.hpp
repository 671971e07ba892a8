#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/units.hpp"

namespace carillon::core {

/// A value as it stands in a resolved configuration.
struct ConfigText {
  std::string value;    ///< YAML on one line
  std::string comment;  ///< its unit; may be empty
};

/// A text that every YAML reader (1.1 or 1.2) reads back as this text: quoted where it must be.
std::string yaml_text(std::string_view text);

/// A number with the fewest digits that read back as the same double.
std::string yaml_number(double value);

ConfigText yaml_quantity(double value, Dimension dimension);
ConfigText yaml_quantities(const std::vector<double>& values, Dimension dimension);

}  // namespace carillon::core
