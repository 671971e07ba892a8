#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/config.hpp"
#include "core/config_tree.hpp"

namespace carillon::dataset::sweep {

/// `{from: 0.2 s, to: 1 s, count: 5, spacing: log}`: numbers in one unit.
struct SweepRange {
  double from = 0, to = 0;
  std::string unit;  ///< as it was written; "" for bare numbers
  bool logarithmic = false;
  std::int64_t count = 0;  ///< of values, both ends included; 0: by step
  double step = 0;         ///< 0: by count; 0 and no count: anything between the ends
  bool continuous() const { return count == 0 && step == 0; }
};

/// One value of a swept key.
struct SweepValue {
  std::string text;   ///< as --set takes it
  std::string label;  ///< for people and folders; the text where it has no name
  bool operator<(const SweepValue& other) const { return text < other.text; }
};

/// The texts of a range's values: the ends as they are, what lies between by count rounded to six
/// digits.
std::vector<SweepValue> values_of(const SweepRange& range);

/// Draw number `draw` of a key: one of the values, or of the numbers of a continuous range. Depends
/// on nothing else than seed, key and number, so that neither a larger count nor another key
/// changes it.
SweepValue draw_value(const std::vector<SweepValue>& values, const std::optional<SweepRange>& range,
                      std::uint64_t seed, const std::string& key, std::int64_t draw);

/// Reads a mapping with from, to, and count or step, and spacing.
/// @throws ConfigError
SweepRange read_range(core::ConfigNode node);

/// YAML on one line that reads back as this value, for `--set key=value`.
std::string flow_text(const core::ConfigTree& value);

}  // namespace carillon::dataset::sweep
