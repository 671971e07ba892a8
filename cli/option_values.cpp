#include "cli/option_values.hpp"

#include <fmt/format.h>

#include "core/quantity_list.hpp"

namespace carillon::cli {

double option_quantity(const std::string& text, core::Dimension dimension, const char* option) {
  return at_option(option, [&] { return core::parse_quantity(text, dimension); });
}

Vec3 parse_position(const std::string& text, const char* option) {
  const std::vector<double> values =
      at_option(option, [&] { return core::parse_quantities(text, core::Dimension::length); });
  if (values.size() != 3) {
    throw core::InputError(
        fmt::format("{} {}: {} value{} instead of three", option, text, values.size(),
                    values.size() == 1 ? "" : "s"),
        "write x,y,z in metres, as in 0.05,0.02,0, or with a unit for all, as in 5,2,0cm");
  }
  return {values[0], values[1], values[2]};
}

}  // namespace carillon::cli
