#include "cli/option_values.hpp"

namespace carillon::cli {

double option_quantity(const std::string& text, core::Dimension dimension, const char* option) {
  return at_option(option, [&] { return core::parse_quantity(text, dimension); });
}

}  // namespace carillon::cli
