#include "eval/networks/detail/equaliser.hpp"

#include <cmath>

namespace carillon::eval::networks {

namespace {

constexpr std::int64_t points = 6;

}  // namespace

torch::Tensor curves_through(const torch::Tensor& values, std::int64_t count) {
  namespace functional = torch::nn::functional;
  return functional::interpolate(values, functional::InterpolateFuncOptions()
                                             .size(std::vector<std::int64_t>{count})
                                             .mode(torch::kLinear)
                                             .align_corners(true));
}

torch::Tensor equalised(const torch::Tensor& spectrograms, const learning::SpectrogramInput& input,
                        double gain) {
  const std::int64_t samples = spectrograms.size(0), bands = spectrograms.size(2);
  const torch::Tensor drawn = gain * (2 * torch::rand({samples, 1, points}) - 1);
  const torch::Tensor curve = curves_through(drawn, bands).unsqueeze(3);
  if (input.scale == learning::SpectrogramScale::power) {
    const torch::Tensor louder = spectrograms * torch::exp(curve * (std::log(10.0) / 10));
    return louder / louder.amax({1, 2, 3}, true).clamp_min(1e-30);
  }
  const torch::Tensor sounds = spectrograms.gt(0);
  const torch::Tensor louder =
      torch::where(sounds, spectrograms + curve / input.range, spectrograms - gain / input.range);
  const torch::Tensor relative = louder + (1 - louder.amax({1, 2, 3}, true));
  return torch::where(sounds, relative.clamp_min(0), torch::zeros({}));
}

}  // namespace carillon::eval::networks
