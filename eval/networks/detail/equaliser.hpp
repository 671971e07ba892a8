#pragma once

#include <torch/torch.h>

#include "eval/learning/modality.hpp"

namespace carillon::eval::networks {

/// Straight between values at equal distances, the first and the last at the ends.
/// @param values  curves x 1 x values
/// @return curves x 1 x count
torch::Tensor curves_through(const torch::Tensor& values, std::int64_t count);

/// Each spectrogram as through a drawn equaliser (as FilterAugment, Nam, Kim and Park 2022, with
/// curves in place of steps): what a place, a microphone or a striker does to the balance of
/// frequencies tells nothing of the material, and a network that meets all of them listens to how
/// long bands ring. Draws from torch's generator.
/// @param spectrograms  samples x 1 x bands x frames, as a network gets them
/// @param gain          greatest gain and loss [dB], at six points of the bands, straight between
/// @return the loudest cell of each is 1 again; cells at 0, which decibels have below their range,
///         stay there
torch::Tensor equalised(const torch::Tensor& spectrograms, const learning::SpectrogramInput& input,
                        double gain);

}  // namespace carillon::eval::networks
