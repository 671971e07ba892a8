#pragma once

#include <nlohmann/json.hpp>

#include "core/columns.hpp"
#include "core/hdf5.hpp"

namespace carillon::dataset::regenerate {

/// Compares the one row of `made` with a row of a shard, value by value to the last bit (NaN equals
/// NaN), types, extents and units too.
/// @return list of {column, stored, made} for each column that differs; null where a side does not
///         have it, long arrays as texts; audio and other long arrays have `difference_db` too:
///         energy of the difference over that of the stored values
nlohmann::json differences(const core::Columns& made, const core::Hdf5Group& shard,
                           std::uint64_t row);

}  // namespace carillon::dataset::regenerate
