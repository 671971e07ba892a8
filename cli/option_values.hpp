#pragma once

#include <string>

#include "core/error.hpp"
#include "core/units.hpp"
#include "core/vectors.hpp"

namespace carillon::cli {

/// What `read` returns of an option's value; what it throws names the option.
/// @param option  "--at"
template <class Read>
auto at_option(const std::string& option, Read&& read) {
  try {
    return read();
  } catch (const core::InputError& error) {
    throw core::InputError(option + ": " + error.message(), error.hint());
  }
}

/// The value of an option in SI units.
/// @throws InputError  as core::parse_quantity, with the option's name
double option_quantity(const std::string& text, core::Dimension dimension, const char* option);

/// Three numbers in metres or with units: "0.1,0,0.02", "10,0,2cm", "10cm,0,2cm".
/// @throws InputError  with the option's name
Vec3 parse_position(const std::string& text, const char* option);

}  // namespace carillon::cli
