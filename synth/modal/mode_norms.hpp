#pragma once

#include <complex>
#include <cstddef>
#include <span>

namespace carillon::synth::modal {

/// Samples Re(amplitude exp(pole n / fs)), n = 0, 1, ...
struct SampledPartial {
  std::complex<double> amplitude;
  std::complex<double> step;  ///< pole / fs
};

/// Sum of exp(x n) over n = 0 ... count - 1, without cancellation for small x.
std::complex<double> geometric_sum(const std::complex<double>& x, std::size_t count);

/// Sum over n of the product of two partials' samples.
double product(const SampledPartial& a, const SampledPartial& b, std::size_t count);

/// The L2 norm of the sum of all partials over `count` samples, by all their products in closed
/// form, less or more what rounding may hide (1e-9 of the sum of all norms, squared).
struct NormBounds {
  double low = 0;
  double high = 0;
};
NormBounds norm_of_sum(std::span<const SampledPartial> partials, std::size_t count);

}  // namespace carillon::synth::modal
