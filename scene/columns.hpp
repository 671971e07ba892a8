#pragma once

#include <span>

#include "core/columns.hpp"

namespace carillon::scene {

/// Every column that a shard may have: what writes one, `check` and docs/format.md have it from
/// here. An effect's own are there when it runs, in every sample.
std::span<const core::ColumnRule> columns();

}  // namespace carillon::scene
