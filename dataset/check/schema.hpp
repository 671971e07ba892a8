#pragma once

#include "dataset/check/folder.hpp"

namespace carillon::dataset::check {

/// Every shard that is there: columns as docs/format.md names them, of one type, extent and unit in
/// all shards, of as many rows as planned.
/// @param readable  takes the samples tasks whose shard can be opened and has all columns, for
///                  checks that read them
Finding check_schema(const DatasetFolder& folder, std::vector<std::size_t>& readable);

}  // namespace carillon::dataset::check
