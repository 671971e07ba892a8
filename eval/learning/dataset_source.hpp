#pragma once

#include <filesystem>
#include <memory>

#include "eval/learning/sample_source.hpp"

namespace carillon::eval::learning {

/// Samples of a dataset's folder (docs/format.md).
///
/// Spectrograms come from the column `mel`; where there is none they are made from `audio` with 64
/// bands and 25 frames. Voxels are the objects', frames the objects' in the sample's
/// material, or of simulations the sample's own.
///
/// @param listener  whose audio, where there are several
/// @throws FileError   no index.h5 that can be read
///         InputError  no such listener
std::unique_ptr<SampleSource> open_dataset_source(const std::filesystem::path& folder,
                                                  std::size_t listener = 0);

}  // namespace carillon::eval::learning
