#pragma once

#include "dataset/configuration/configuration.hpp"

namespace carillon::dataset::configuration {

/// Fills in what the views of a configuration cost, once their options are read: spectrograms for
/// each row of a sound, voxels and frames for each shape, motion and all it brings for each
/// simulation.
void price_views(BuildConfig& config);

}  // namespace carillon::dataset::configuration
