#include "core/quantity_list.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>

#include "core/error.hpp"
#include "core/text.hpp"

namespace carillon::core {

namespace {

struct NumberAndUnit {
  bool number = false;  ///< else nothing else here is known
  bool zero = false;
  std::string digits, unit;
};

NumberAndUnit split(std::string_view text) {
  const std::string_view whole = trimmed(text);
  const std::string_view unsigned_text =
      whole.substr(whole.starts_with('+') && !whole.starts_with("+-") ? 1 : 0);
  double value = 0;
  const auto [end, error] =
      std::from_chars(unsigned_text.data(), unsigned_text.data() + unsigned_text.size(), value);
  if (error != std::errc()) return {};
  const auto length = static_cast<std::size_t>(end - whole.data());
  return {true, value == 0, std::string(whole.substr(0, length)),
          std::string(trimmed(whole.substr(length)))};
}

}  // namespace

std::vector<std::string> with_own_units(std::vector<std::string> texts) {
  std::vector<NumberAndUnit> parts;
  for (const std::string& text : texts) parts.push_back(split(text));
  if (!std::all_of(parts.begin(), parts.end(), [](const auto& part) { return part.number; })) {
    return texts;
  }
  const auto bare = [](const NumberAndUnit& part) { return part.unit.empty(); };
  const auto lacks = [](const NumberAndUnit& part) { return part.unit.empty() && !part.zero; };
  if (std::none_of(parts.begin(), parts.end(), lacks)) return texts;
  if (std::all_of(parts.begin(), parts.end(), bare)) return texts;
  if (bare(parts.back()) || !std::all_of(parts.begin(), parts.end() - 1, bare)) {
    const auto with =
        std::find_if(parts.begin(), parts.end(), [&](const auto& part) { return !bare(part); });
    std::vector<std::string> once, each;
    for (const NumberAndUnit& part : parts) {
      once.push_back(part.digits);
      each.push_back(part.digits + " " + (bare(part) ? with->unit : part.unit));
    }
    throw InputError(
        fmt::format("\"{}\": some of these have a unit and others none", fmt::join(texts, ", ")),
        fmt::format("one unit at the end is for all, as in {} {}; or each has its own, as in {}",
                    fmt::join(once, ", "), with->unit, fmt::join(each, ", ")));
  }
  for (std::string& text : texts) {
    if (&text != &texts.back()) text += " " + parts.back().unit;
  }
  return texts;
}

std::vector<double> parse_quantities(std::string_view text, Dimension dimension) {
  std::vector<std::string> texts(1);
  for (const char c : text) {
    if (c == ',') {
      texts.emplace_back();
    } else {
      texts.back() += c;
    }
  }
  std::vector<double> values;
  for (const std::string& one : with_own_units(std::move(texts))) {
    values.push_back(parse_quantity(one, dimension));
  }
  return values;
}

Vec3 parse_position(std::string_view text, std::string_view name) {
  std::vector<double> values;
  try {
    values = parse_quantities(text, Dimension::length);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", name, error.message()), error.hint());
  }
  if (values.size() != 3) {
    throw InputError(
        fmt::format("{} {}: {} value{} instead of three", name, text, values.size(),
                    values.size() == 1 ? "" : "s"),
        "write x,y,z in metres, as in 0.05,0.02,0, or with a unit for all, as in 5,2,0cm");
  }
  return {values[0], values[1], values[2]};
}

}  // namespace carillon::core
