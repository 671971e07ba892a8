#pragma once

#include <vector>

#include "core/columns.hpp"
#include "core/hdf5.hpp"
#include "dataset/regenerate/regenerate.hpp"

namespace carillon::dataset::regenerate {

/// Compares the one row of `made` with a row of a shard, value by value to the last bit (NaN equals
/// NaN), types, extents and units too.
/// @return the columns that differ
std::vector<ColumnDifference> differences(const core::Columns& made, const core::Hdf5Group& shard,
                                          std::uint64_t row);

}  // namespace carillon::dataset::regenerate
