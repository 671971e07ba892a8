#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/units.hpp"
#include "core/vectors.hpp"

namespace carillon::core {

/// Texts of quantities that stand in one list, each with its own unit. A unit behind the last alone
/// is meant for all: 5, 2, 0 cm are 5 cm, 2 cm and 0 cm. Without any, all are in SI units; a bare 0
/// needs none. What is no number is left as it is.
/// @throws InputError  units on some of them in another way; says how to write it
std::vector<std::string> with_own_units(std::vector<std::string> texts);

/// Values of "5,2,0cm", "5cm,2cm,0cm" or "0.05,0.02,0" in SI units.
/// @throws InputError  as with_own_units and parse_quantity
std::vector<double> parse_quantities(std::string_view text, Dimension dimension);

/// Three numbers in metres or with units: "0.1,0,0.02", "10,0,2cm", "10cm,0,2cm".
/// @param name  of the option, for messages
/// @throws InputError  with the option's name
Vec3 parse_position(std::string_view text, std::string_view name);

}  // namespace carillon::core
