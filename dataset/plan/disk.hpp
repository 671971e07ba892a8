#pragma once

#include "dataset/configuration/configuration.hpp"

namespace carillon::dataset::plan {

/// Bytes of the columns of a sample that weigh, before compression: audio (also as WAV) and
/// spectrograms.
double sample_bytes(const configuration::BuildConfig& config);

}  // namespace carillon::dataset::plan
