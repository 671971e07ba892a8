#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/config.hpp"
#include "core/config_tree.hpp"
#include "dataset/sweep/sweep.hpp"

namespace carillon::dataset::sweep {

/// The texts of a range's values: the ends as they are, what lies between by count rounded to six
/// digits.
std::vector<SweepValue> values_of(const SweepRange& range);

/// A number of a continuous range, from its begin (0) to its end (1), to six digits.
SweepValue value_between(const SweepRange& range, double fraction);

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
