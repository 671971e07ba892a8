#include "synth/signal/cross_fade.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"

namespace carillon::synth::signal {

void append_cross_faded(std::vector<double>& samples, std::span<const float> next,
                        std::size_t overlap) {
  if (overlap > std::min(samples.size(), next.size())) {
    throw core::InputError(fmt::format("a cross-fade of {} samples between {} and {}", overlap,
                                       samples.size(), next.size()));
  }
  double* mixed = samples.data() + (samples.size() - overlap);
  for (std::size_t i = 0; i < overlap; ++i) {
    // Between the ends, so that the first and the last sample of the fade hold both.
    const double turn =
        std::numbers::pi / 2 * (static_cast<double>(i) + 0.5) / static_cast<double>(overlap);
    mixed[i] = std::cos(turn) * mixed[i] + std::sin(turn) * next[i];
  }
  samples.insert(samples.end(), next.begin() + static_cast<std::ptrdiff_t>(overlap), next.end());
}

}  // namespace carillon::synth::signal
