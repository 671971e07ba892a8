#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace carillon::synth::recording {

/// Samples [begin, end) of a clip in which there is something to hear; empty for a silent clip.
struct ActivePart {
  std::size_t begin = 0;
  std::size_t end = 0;
  bool empty() const { return end <= begin; }
  std::size_t size() const { return empty() ? 0 : end - begin; }
};

/// The active part of a noise-free clip. It begins with the first sample whose energy (the sum of
/// the squares of all rows) is not 60 dB or more below that of the greatest, and ends with the last
/// one where the energy of the 10 ms that follow is not more than 60 dB below its maximum. An
/// exponential decay is active for its T60.
///
/// @param clip  rows x samples, row by row: one clip heard in several places
/// @throws InputError  a sample is not finite, or the clip is not whole rows
ActivePart active_part(std::span<const float> clip, std::size_t rows, double sample_rate);

/// Mean square of the part, over all rows; 0 for an empty part.
double mean_power(std::span<const float> clip, std::size_t rows, const ActivePart& part);
double mean_power(std::span<const double> clip, std::size_t rows, const ActivePart& part);

/// Noise whose power over the active part is this fraction of its power over the clip will do: were
/// it much weaker there, its scaled up rest would drown everything.
constexpr double min_noise_fraction = 0.01;

/// Adds noise such that 10 log10(signal power / noise power) is `decibels`, both powers being means
/// over the active part and over all rows; the differences of level between rows are kept.
///
/// @param clip   rows x samples, takes the sum
/// @param noise  likewise, of any level
/// @return the factor that the noise was scaled by
/// @throws InputError  the active part is empty (a silent clip has no such ratio) or the noise is
///                     silent there; the sum is beyond single precision; the sizes differ
double add_noise(std::span<float> clip, std::span<const double> noise, std::size_t rows,
                 const ActivePart& part, double decibels);

}  // namespace carillon::synth::recording
