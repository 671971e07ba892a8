#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "synth/modal/resonators.hpp"

namespace carillon::synth {

/// The kernel's voices as synthesize() rings them, but in double precision: adds the sum over
/// partials of Re(amplitude exp((-d + i omega) tau_n)), tau_n = first_time + n / sample_rate, to
/// samples[n].
/// @param first_time  time of samples[0] [s], >= 0
/// @param tail        a partial ends once the largest value it can still add is below `tail` times
///                    the peak of |samples| so far, divided by the number of partials; 0: never
/// @param peak        peak before samples[0]
inline void add_partials(std::span<const modal::Partial> partials, long double first_time,
                         double sample_rate, double tail, double peak, std::span<double> samples) {
  std::vector<modal::Rotation> rotations;
  std::vector<modal::Voice> voices;
  rotations.reserve(partials.size());
  for (const modal::Partial& partial : partials) {
    if (partial.amplitude == 0.0) continue;
    rotations.push_back(
        modal::make_rotation(partial.decay_rate, partial.angular_frequency, sample_rate));
    voices.push_back(
        {&rotations.back(),
         partial.amplitude *
             modal::exponential(partial.decay_rate, partial.angular_frequency, first_time)});
  }
  const double fraction = voices.empty() ? 0 : tail / static_cast<double>(voices.size());
  modal::SampleBlock block{};
  for (std::size_t begin = 0; begin < samples.size() && !voices.empty();
       begin += modal::block_size) {
    modal::drop_below(fraction * peak, voices);
    const std::size_t count = std::min(modal::block_size, samples.size() - begin);
    std::copy_n(samples.begin() + static_cast<std::ptrdiff_t>(begin), count, block.samples.begin());
    modal::add_voices(voices, count, block);
    modal::move_on(voices, count);
    peak = std::max(peak, modal::peak_of(block, count));
    std::copy_n(block.samples.begin(), count, samples.begin() + static_cast<std::ptrdiff_t>(begin));
  }
}

}  // namespace carillon::synth
