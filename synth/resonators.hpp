#pragma once

#include <span>

#include "synth/modal_response.hpp"

namespace carillon::synth {

/// Adds the sum over partials of Re(amplitude exp((-d + i omega) tau_n)), tau_n = first_time +
/// n / sample_rate, to samples[n].
///
/// Each partial is a phasor turned by one complex product per vector of samples and set anew from
/// its exponential every block, so that errors do not grow with the clip's length. Partials are
/// summed in their order whatever the vector width; only fused products differ between kinds of
/// CPU (about 1e-15 of the sum).
///
/// @param first_time  time of samples[0] [s], >= 0
/// @param tail        a partial ends once the largest value it can still add is below `tail` times
///                    the peak of |samples| so far, divided by the number of partials; 0: never
/// @param peak        peak before samples[0]
void add_partials(std::span<const Partial> partials, long double first_time, double sample_rate,
                  double tail, double peak, std::span<double> samples);

}  // namespace carillon::synth
