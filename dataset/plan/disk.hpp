#pragma once

#include "dataset/configuration/configuration.hpp"

namespace carillon::dataset::plan {

/// The columns of a sample that weigh, before compression [byte].
struct SampleBytes {
  double audio = 0;   ///< of all listeners
  double wav = 0;     ///< the same in a file of its own, if asked for
  double mel = 0;     ///< spectrograms
  double motion = 0;  ///< poses, strikes and touch of a simulation
  double pixels = 0;  ///< its frames, depth maps and masks

  double total() const { return audio + wav + mel + motion + pixels; }
};
SampleBytes sample_bytes(const configuration::BuildConfig& config);

}  // namespace carillon::dataset::plan
