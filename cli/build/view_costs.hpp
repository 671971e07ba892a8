#pragma once

#include "cli/build/configuration.hpp"

namespace carillon::cli {

/// Fills in what the views of a configuration cost, once their options are read: spectrograms for
/// each row of a sound, voxels and frames for each shape, motion and all it brings for each take.
void price_views(BuildConfig& config);

}  // namespace carillon::cli
