#pragma once

#include "cli/build/configuration.hpp"

namespace carillon::cli {

/// Bytes of the columns of a sample that weigh, before compression: audio (also as WAV) and
/// spectrograms.
double sample_bytes(const BuildConfig& config);

}  // namespace carillon::cli
