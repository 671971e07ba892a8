#pragma once

#include "dataset/check/folder.hpp"

namespace carillon::dataset::check {

// What a build writes last follows from the plan, the journal and the other files. It is in no list
// of checksums: it is made again and compared.

/// index.h5 against the one that the plan, the shards and the modes files make.
/// @param readable  samples tasks whose shard can be read
Finding check_index(const DatasetFolder& folder, const std::vector<std::size_t>& readable);

/// dataset.json against the one that the plan and the journal make. Versions can differ: those of
/// other libraries than here are noted. Hashes of files are the matter of another check.
Finding check_description(const DatasetFolder& folder);

}  // namespace carillon::dataset::check
