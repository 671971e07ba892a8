#pragma once

#include <span>

#include "eval/features/extract_features.hpp"

namespace carillon::eval::features {

/// Modal features as the papers find them: power spectrograms of several window lengths; the
/// highest peak over all of them; frequency, decay rate and amplitude fitted to the power around it
/// (Gauss-Newton); its power taken out of every spectrogram; and so on until 99.99 % of the power
/// is explained or no peak is 10 dB above the noise (Ren, Yeh and Lin 2013; Sterling 2019, 3.3.1.1
/// and 4.2.2). Pairs closer than a window can tell apart are one feature. Errors are not known
/// (NaN), neither are phases.
/// @param samples      after contact
/// @param after_onset  samples between the onset and the first of these
/// @param set          features, hums, explained (of power) and residual (the samples) are filled
void by_peaks(std::span<const double> samples, double sample_rate, double after_onset,
              const FeatureOptions& options, FeatureSet& set);

}  // namespace carillon::eval::features
