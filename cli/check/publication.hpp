#pragma once

#include "cli/check/folder.hpp"

namespace carillon::cli {

/// croissant.json as dataset.json and the index make it; a note of what a published dataset should
/// say and this one does not.
Finding check_publication(const DatasetFolder& folder);

}  // namespace carillon::cli
