#pragma once

#include <optional>
#include <span>
#include <string>

#include "dataset/configuration/configuration.hpp"

namespace carillon::dataset::check {

/// One column of docs/format.md.
struct ColumnRule {
  const char* name;   ///< "alpha" stands for alpha1, alpha2, ...
  const char* type;   ///< as Hdf5Group::element_type
  const char* inner;  ///< extent of a row: "" single value; "3"; "*": any count; "*,3"; or "audio",
                      ///< "mel", "listeners": as the configuration says
  const char* units;  ///< those that may be, separated by '|'; "": any
  const char* when;   ///< "always"; "may"; or the effects that bring it, separated by '|'
  bool may_be_nan = false;
};

/// Every column that a shard may have.
std::span<const ColumnRule> column_rules();
/// The rule of a column; null for one that docs/format.md does not know.
const ColumnRule* find_rule(const std::string& column);

/// Whether a build's shards have the column: yes, no, or (nothing) perhaps.
std::optional<bool> expected(const ColumnRule& rule, const configuration::BuildConfig& config);

/// Type, row's extent and unit of a column against its rule; "" or what is wrong.
std::string break_of(const ColumnRule& rule, const configuration::BuildConfig& config,
                     const std::string& type, const core::Extent& inner, const std::string& unit);

}  // namespace carillon::dataset::check
