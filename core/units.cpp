#include "core/units.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <span>

#include "core/error.hpp"
#include "core/text.hpp"

namespace carillon::core {

namespace {

/// value [SI] = number * times / over. Both are exact, so "12 cm" is the double nearest to 0.12.
struct Unit {
  Dimension dimension;
  std::string_view name;  ///< without blanks
  double times = 1;
  double over = 1;
};

// The first of each dimension is the SI unit; the spellings without a message of their own
// (`hidden`) stand in `aliases`.
constexpr double kilo = 1e3, mega = 1e6, giga = 1e9;
constexpr std::array units = {
    Unit{Dimension::none, "%", 1, 100},
    Unit{Dimension::length, "m"},
    Unit{Dimension::length, "cm", 1, 100},
    Unit{Dimension::length, "mm", 1, kilo},
    Unit{Dimension::length, "um", 1, mega},
    Unit{Dimension::length, "km", kilo},
    Unit{Dimension::length, "in", 254, 10000},
    Unit{Dimension::time, "s"},
    Unit{Dimension::time, "ms", 1, kilo},
    Unit{Dimension::time, "us", 1, mega},
    Unit{Dimension::time, "min", 60},
    Unit{Dimension::time, "h", 3600},
    Unit{Dimension::frequency, "Hz"},
    Unit{Dimension::frequency, "kHz", kilo},
    Unit{Dimension::frequency, "MHz", mega},
    Unit{Dimension::pressure, "Pa"},
    Unit{Dimension::pressure, "kPa", kilo},
    Unit{Dimension::pressure, "MPa", mega},
    Unit{Dimension::pressure, "GPa", giga},
    Unit{Dimension::density, "kg/m^3"},
    Unit{Dimension::density, "kg/m3"},
    Unit{Dimension::density, "g/cm^3", kilo},
    Unit{Dimension::density, "g/cm3", kilo},
    Unit{Dimension::mass, "kg"},
    Unit{Dimension::mass, "g", 1, kilo},
    Unit{Dimension::mass, "mg", 1, mega},
    Unit{Dimension::speed, "m/s"},
    Unit{Dimension::speed, "mm/s", 1, kilo},
    Unit{Dimension::speed, "km/h", kilo, 3600},
    Unit{Dimension::angle, "rad"},
    Unit{Dimension::angle, "deg", std::numbers::pi, 180},
    Unit{Dimension::force, "N"},
    Unit{Dimension::force, "mN", 1, kilo},
    Unit{Dimension::force, "kN", kilo},
    Unit{Dimension::impulse, "Ns"},
    Unit{Dimension::impulse, "N*s"},
    Unit{Dimension::impulse, "mNs", 1, kilo},
    Unit{Dimension::impulse, "mN*s", 1, kilo},
    Unit{Dimension::stiffness, "N/m"},
    Unit{Dimension::stiffness, "kN/m", kilo},
    Unit{Dimension::stiffness, "N/mm", kilo},
    Unit{Dimension::resistance, "Ns/m"},
    Unit{Dimension::resistance, "N*s/m"},
    Unit{Dimension::resistance, "kg/s"},
    Unit{Dimension::memory, "B"},
    Unit{Dimension::memory, "KiB", 1024},
    Unit{Dimension::memory, "MiB", 1024.0 * 1024},
    Unit{Dimension::memory, "GiB", 1024.0 * 1024 * 1024},
    Unit{Dimension::memory, "kB", kilo},
    Unit{Dimension::memory, "MB", mega},
    Unit{Dimension::memory, "GB", giga},
    Unit{Dimension::level, "dB"},
};

struct Alias {
  std::string_view written;
  std::string_view meant;
};
// Characters beyond ASCII and words that people type or paste.
constexpr std::array aliases = {
    Alias{"\u00b5", "u"},  // micro sign
    Alias{"\u03bc", "u"},  // Greek mu
    Alias{"inches", "in"},  Alias{"inch", "in"},  Alias{"\u00b3", "^3"},
    Alias{"\u00b0", "deg"}, Alias{"\u00b7", "*"}, Alias{"\u00a0", ""},
};

constexpr std::string_view blanks = " \t\r\n";

std::string plain_unit(std::string_view text) {
  std::string unit;
  for (char c : text) {
    if (blanks.find(c) == std::string_view::npos) unit += c;
  }
  for (const Alias& alias : aliases) {
    for (auto at = unit.find(alias.written); at != std::string::npos;
         at = unit.find(alias.written)) {
      unit.replace(at, alias.written.size(), alias.meant);
    }
  }
  return unit;
}

}  // namespace

std::string_view dimension_name(Dimension dimension) {
  switch (dimension) {
    case Dimension::none:
      return "plain number";
    case Dimension::length:
      return "length";
    case Dimension::time:
      return "time";
    case Dimension::frequency:
      return "frequency";
    case Dimension::pressure:
      return "pressure";
    case Dimension::density:
      return "density";
    case Dimension::mass:
      return "mass";
    case Dimension::speed:
      return "speed";
    case Dimension::angle:
      return "angle";
    case Dimension::force:
      return "force";
    case Dimension::impulse:
      return "impulse";
    case Dimension::stiffness:
      return "stiffness";
    case Dimension::resistance:
      return "mechanical resistance";
    case Dimension::memory:
      return "memory size";
    case Dimension::level:
      return "level";
  }
  return "quantity";
}

std::vector<std::string> unit_names(Dimension dimension) {
  std::vector<std::string> names;
  for (const Unit& unit : units) {
    if (unit.dimension == dimension) names.emplace_back(unit.name);
  }
  return names;
}

namespace {

std::string units_hint(Dimension dimension) {
  if (dimension == Dimension::none) return "a plain number, or a percentage such as \"5 %\"";
  return fmt::format("units of a {}: {}; a bare number is in {}", dimension_name(dimension),
                     fmt::join(unit_names(dimension), ", "), unit_name(dimension));
}

[[noreturn]] void refuse_unit(std::string_view text, const std::string& unit, Dimension dimension) {
  for (const Unit& other : units) {
    if (other.name == unit) {
      const bool wants_number = dimension == Dimension::none;
      throw InputError(
          fmt::format("\"{}\" is a {}; a {} is wanted", text,
                      other.name == "%" ? "percentage" : dimension_name(other.dimension),
                      dimension_name(dimension)),
          wants_number ? "leave the unit out" : units_hint(dimension));
    }
  }
  const std::string near = nearest_name(unit, unit_names(dimension));
  throw InputError(near.empty() ? fmt::format("\"{}\": unknown unit \"{}\"", text, unit)
                                : fmt::format("\"{}\": unknown unit \"{}\"; did you mean \"{}\"?",
                                              text, unit, near),
                   units_hint(dimension));
}

}  // namespace

double parse_quantity(std::string_view text, Dimension dimension) {
  const std::string_view trimmed_text = trimmed(text);
  // from_chars reads the same in every locale; it takes no plus sign.
  const bool plus = trimmed_text.starts_with('+') && !trimmed_text.starts_with("+-");
  const std::string_view digits = trimmed_text.substr(plus ? 1 : 0);
  double number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error == std::errc::result_out_of_range) {
    throw InputError(fmt::format("\"{}\" is beyond the range of a double", trimmed_text));
  }
  if (error != std::errc() || !std::isfinite(number)) {
    throw InputError(fmt::format("\"{}\" is not a finite number", trimmed_text),
                     units_hint(dimension));
  }
  const std::string unit = plain_unit(digits.substr(static_cast<std::size_t>(end - digits.data())));
  if (unit.empty()) return number;
  for (const Unit& known : units) {
    if (known.dimension != dimension || known.name != unit) continue;
    const double value = number * known.times / known.over;
    if (!std::isfinite(value)) {
      throw InputError(fmt::format("\"{}\" is beyond the range of a double", trimmed_text));
    }
    return value;
  }
  refuse_unit(trimmed_text, unit, dimension);
}

double parse_unit_of_length(std::string_view name) {
  const std::string unit = plain_unit(name);
  for (const Unit& known : units)
    if (known.dimension == Dimension::length && known.name == unit) return known.times / known.over;
  throw InputError(fmt::format("\"{}\" is no unit of length", name), "write mm, cm, m or inch");
}

std::string unit_name(Dimension dimension) {
  switch (dimension) {
    case Dimension::none:
      return "1";
    case Dimension::impulse:
      return "N s";
    case Dimension::resistance:
      return "N s/m";
    default:
      break;
  }
  const auto first = std::find_if(units.begin(), units.end(),
                                  [&](const Unit& unit) { return unit.dimension == dimension; });
  return std::string(first->name);
}

namespace {

std::string folded(std::string_view word) {
  std::string plain(word);
  for (char& c : plain) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    if (c == '-' || c == ' ') c = '_';
  }
  return plain;
}

/// Insertions, deletions, replacements and swaps of neighbours that turn a into b.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const bool same = a[i - 1] == b[j - 1];
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (same ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        row[j] = std::min(row[j], before[j - 2] + 1);
      }
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

}  // namespace

std::string nearest_name(std::string_view word, const std::vector<std::string>& candidates) {
  // A third of the letters may be wrong; beyond that it is another word. Long words cost time.
  if (word.empty() || word.size() > 100) return {};
  std::size_t best = std::max<std::size_t>(1, word.size() / 3) + 1;
  std::string nearest;
  for (const std::string& candidate : candidates) {
    if (candidate.size() > 100) continue;
    const std::size_t distance = edit_distance(folded(word), folded(candidate));
    if (distance < best) {
      best = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

}  // namespace carillon::core
