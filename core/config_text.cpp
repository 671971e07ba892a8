#include "core/config_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace carillon::core {

namespace {

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// Words that YAML 1.1 or 1.2 takes for a truth value or for nothing.
bool is_reserved(std::string_view text) {
  constexpr std::array words = {"true", "false", "yes", "no", "on", "off", "null", "y", "n"};
  std::string lower(text);
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return std::find(words.begin(), words.end(), lower) != words.end();
}

bool may_stand_plain(std::string_view text) {
  if (text.empty() || !is_letter(text.front()) || is_reserved(text)) return false;
  return std::all_of(text.begin(), text.end(), [](char c) {
    return is_letter(c) || is_digit(c) || c == '.' || c == '-' || c == '/';
  });
}

std::string comment(Dimension dimension) {
  return dimension == Dimension::none ? "" : unit_name(dimension);
}

}  // namespace

std::string yaml_text(std::string_view text) {
  if (may_stand_plain(text)) return std::string(text);
  std::string quoted = "\"";
  for (char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (c == '\n') {
      quoted += "\\n";
    } else if (c == '\t') {
      quoted += "\\t";
    } else if (code < 0x20 || code == 0x7f) {
      quoted += fmt::format("\\x{:02x}", code);
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

std::string yaml_number(double value) {
  if (std::isnan(value)) return ".nan";
  if (std::isinf(value)) return value > 0 ? ".inf" : "-.inf";
  std::string text = fmt::format("{}", value);
  // YAML 1.1 readers take "1e-05" for a text; "1.0e-05" is a number to all.
  const std::size_t exponent = text.find('e');
  if (exponent != std::string::npos && text.find('.') == std::string::npos) {
    text.insert(exponent, ".0");
  }
  return text;
}

ConfigText yaml_quantity(double value, Dimension dimension) {
  return {yaml_number(value), comment(dimension)};
}

ConfigText yaml_quantities(const std::vector<double>& values, Dimension dimension) {
  std::string list;
  for (double value : values) list += (list.empty() ? "" : ", ") + yaml_number(value);
  return {"[" + list + "]", comment(dimension)};
}

}  // namespace carillon::core
