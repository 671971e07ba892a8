#pragma once

#include "dataset/check/folder.hpp"

namespace carillon::dataset::check {

/// croissant.json says of the dataset what dataset.json does, and its records have the columns of
/// index.h5 (its files are the checksums' matter); a note of what a published dataset should say
/// and this one does not.
Finding check_publication(const DatasetFolder& folder);

}  // namespace carillon::dataset::check
