#pragma once

#include <string>

#include "core/error.hpp"
#include "core/quantity_list.hpp"
#include "core/units.hpp"

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

using core::parse_position;

}  // namespace carillon::cli
