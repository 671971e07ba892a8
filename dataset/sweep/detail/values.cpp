#include "dataset/sweep/detail/values.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "core/config_reader.hpp"
#include "core/config_text.hpp"
#include "core/random.hpp"
#include "dataset/sweep/sweep.hpp"

namespace carillon::dataset::sweep {

using core::ConfigNode;
using core::ConfigTree;
using Kind = ConfigTree::Kind;

namespace {

/// "0.2 s" as 0.2 and "s"; nothing where it does not begin with a number.
std::optional<std::pair<double, std::string>> split_number(const std::string& text) {
  double number = 0;
  const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
  const auto [end, error] = std::from_chars(begin, text.data() + text.size(), number);
  if (error != std::errc() || !std::isfinite(number)) return {};
  const std::string rest(end, text.data() + text.size());
  const std::size_t unit = rest.find_first_not_of(' ');
  return std::pair{number, unit == std::string::npos ? "" : rest.substr(unit)};
}

std::pair<double, std::string> number_at(ConfigNode& node, const std::string& key) {
  const std::string text = node.text(key);
  const auto number = split_number(text);
  if (!number)
    node.fail(key, fmt::format("a number, with a unit or without, is wanted, not \"{}\"", text));
  return *number;
}

SweepValue with_unit(const std::string& number, const std::string& unit) {
  const std::string text = unit.empty() ? number : number + " " + unit;
  return {text, text};
}

double between(const SweepRange& range, double fraction) {
  if (range.logarithmic) return range.from * std::pow(range.to / range.from, fraction);
  return range.from + fraction * (range.to - range.from);
}

std::int64_t steps_in(const SweepRange& range) {
  // A last step that misses the end by rounding alone still counts.
  return static_cast<std::int64_t>(std::floor((range.to - range.from) / range.step + 1e-9));
}

}  // namespace

SweepRange read_range(ConfigNode node) {
  SweepRange range;
  const auto [from, unit] = number_at(node, "from");
  const auto [to, other_unit] = number_at(node, "to");
  range.from = from;
  range.to = to;
  range.unit = unit;
  if (other_unit != unit) {
    node.fail("to", fmt::format("is in \"{}\" and `from` in \"{}\"", other_unit, unit),
              "write both in the same unit");
  }
  if (!(to > from)) node.fail("to", "must be above `from`");
  range.logarithmic = node.choice("spacing", {"linear", "log"}, "linear") == "log";
  if (range.logarithmic && !(from > 0)) node.fail("from", "must be positive where spacing is log");
  const bool by_count = node.has("count"), by_step = node.has("step");
  if (by_count && by_step) node.fail("step", "stands beside count", "give one of the two");
  if (by_count) {
    range.count = node.integer("count", 2, static_cast<std::int64_t>(max_variants));
  }
  if (by_step) {
    const auto [step, step_unit] = number_at(node, "step");
    if (step_unit != unit) {
      node.fail("step", "and `from` are not in the same unit", "write all in the same unit");
    }
    if (!(step > 0)) node.fail("step", "must be positive");
    if (range.logarithmic) node.fail("step", "is for linear spacing", "give count instead");
    range.step = step;
    if (!((to - from) / step < static_cast<double>(max_variants))) {
      node.fail("step", fmt::format("makes more than {} values", max_variants));
    }
  }
  node.finish();
  return range;
}

std::vector<SweepValue> values_of(const SweepRange& range) {
  std::vector<SweepValue> values;
  if (range.step > 0) {
    for (std::int64_t i = 0; i <= steps_in(range); ++i) {
      const double value = range.from + static_cast<double>(i) * range.step;
      values.push_back(with_unit(fmt::format("{:.12g}", value), range.unit));
    }
    return values;
  }
  for (std::int64_t i = 0; i < range.count; ++i) {
    const bool end = i == 0 || i + 1 == range.count;
    const double fraction = static_cast<double>(i) / static_cast<double>(range.count - 1);
    const double value = i == 0 ? range.from : end ? range.to : between(range, fraction);
    values.push_back(
        with_unit(end ? fmt::format("{}", value) : fmt::format("{:.6g}", value), range.unit));
  }
  return values;
}

SweepValue value_between(const SweepRange& range, double fraction) {
  return with_unit(fmt::format("{:.6g}", between(range, fraction)), range.unit);
}

SweepValue draw_value(const std::vector<SweepValue>& values, const std::optional<SweepRange>& range,
                      std::uint64_t seed, const std::string& key, std::int64_t draw) {
  core::RandomStream random(seed, core::stable_hash(fmt::format("{}/{}", key, draw)), "sweep");
  if (range && range->continuous()) {
    return value_between(*range, random.uniform());
  }
  return values[random.index(values.size())];
}

namespace {

/// Whether YAML reads a text, inside a list or alone, as the scalar that it is.
bool stands_plain(const std::string& text, bool inside) {
  try {
    const ConfigTree read = core::read_yaml(inside ? "[" + text + "]" : text, "", text);
    const ConfigTree* value = &read;
    if (inside) {
      if (read.items.size() != 1) return false;
      value = &read.items.front();
    }
    return value->kind == Kind::scalar && value->scalar == text;
  } catch (const core::ConfigError&) {
    return false;
  }
}

std::string text_of(const ConfigTree& value, bool inside) {
  const auto scalar = [&](const std::string& text) {
    return stands_plain(text, inside) ? text : core::yaml_text(text);
  };
  std::string list;
  switch (value.kind) {
    case Kind::nothing:
      return inside ? "null" : "";
    case Kind::scalar:
      return scalar(value.scalar);
    case Kind::list:
      for (const ConfigTree& item : value.items) {
        list += (list.empty() ? "" : ", ") + text_of(item, true);
      }
      return "[" + list + "]";
    case Kind::mapping:
      for (const core::ConfigEntry& entry : value.entries) {
        list += (list.empty() ? "" : ", ") + core::yaml_text(entry.key) + ": " +
                text_of(entry.value, true);
      }
      return "{" + list + "}";
  }
  return "";
}

}  // namespace

std::string flow_text(const ConfigTree& value) {
  return text_of(value, false);
}

}  // namespace carillon::dataset::sweep
