#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/hdf5.hpp"

namespace carillon::dataset::exporters {

/// Refuses a dataset that is being built, or that lacks files, whose rows would read as zeros;
/// warns where there are fewer samples than were planned.
/// @param arrays  that are read beside the samples' columns, of the index or of its `shapes`
/// @throws InputError
void require_whole(const std::filesystem::path& folder, const core::Hdf5Group& index,
                   const std::vector<std::string>& arrays);

}  // namespace carillon::dataset::exporters
