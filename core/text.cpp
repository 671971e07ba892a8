#include "core/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <sstream>
#include <string_view>

#include "core/error.hpp"
#include "core/random.hpp"
#include "core/units.hpp"

namespace carillon::core {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t\r\n\v\f";
  const auto first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

template <class Number>
std::optional<Number> number_in(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}
template std::optional<double> number_in(std::string_view text);
template std::optional<std::int64_t> number_in(std::string_view text);

std::vector<std::pair<std::string, std::string>> parse_assignments(const std::string& text) {
  std::vector<std::pair<std::string, std::string>> pairs;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ',');) {
    const auto equals = part.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw InputError(fmt::format("\"{}\" is not of the form name=value", part));
    }
    pairs.emplace_back(part.substr(0, equals), part.substr(equals + 1));
  }
  return pairs;
}

std::int64_t whole_bytes(double bytes) {
  constexpr double maximum = static_cast<double>(1ll << 60);
  if (!(bytes >= 1 && bytes <= maximum)) {
    throw InputError(fmt::format("{:.6g} B is no limit of memory", bytes),
                     "it lies between 1 B and 2^60 B; write a unit, as in 16 GiB");
  }
  return static_cast<std::int64_t>(bytes);
}

std::int64_t memory_limit(const std::string& text, const std::string& option) {
  try {
    return whole_bytes(parse_quantity(text, Dimension::memory));
  } catch (const InputError& error) {
    throw InputError(fmt::format("{} {}: {}", option, text, error.message()), error.hint());
  }
}

std::string file_safe(const std::string& name) {
  constexpr std::size_t longest = 60;
  std::string safe;
  for (const char c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '.' || c == '-' || c == '_';
    safe += plain ? c : '_';
  }
  if (safe == name && !safe.empty() && safe.size() <= longest && safe[0] != '.') return safe;
  if (!safe.empty() && safe[0] == '.') safe[0] = '_';
  return fmt::format("{}-{:08x}", safe.substr(0, longest), stable_hash(name) >> 32);
}

std::string typed_command(int argc, const char* const* argv) {
  std::string command = "carillon";
  for (int i = 1; i < argc; ++i) {
    std::string word = argv[i];
    std::replace_if(
        word.begin(), word.end(), [](unsigned char letter) { return letter < ' '; }, ' ');
    const bool bare = !word.empty() && std::all_of(word.begin(), word.end(), [](char letter) {
      return std::isalnum(static_cast<unsigned char>(letter)) != 0 ||
             std::string_view("-_./:=,+@%").find(letter) != std::string_view::npos;
    });
    command += bare ? " " + word : " '" + word + "'";
  }
  return command;
}

}  // namespace carillon::core
