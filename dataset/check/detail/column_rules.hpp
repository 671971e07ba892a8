#pragma once

#include <optional>
#include <string>

#include "core/columns.hpp"
#include "dataset/configuration/configuration.hpp"

namespace carillon::dataset::check {

/// Whether a build's shards have the column: yes, no, or (nothing) perhaps.
std::optional<bool> expected(const core::ColumnRule& rule,
                             const configuration::BuildConfig& config);

/// Type, row's extent and unit of a column against its rule; "" or what is wrong.
std::string break_of(const core::ColumnRule& rule, const configuration::BuildConfig& config,
                     const std::string& type, const core::Extent& inner, const std::string& unit);

}  // namespace carillon::dataset::check
