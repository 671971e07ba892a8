#include "synth/modal/mode_norms.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "synth/modal/detail/phi_functions.hpp"

namespace carillon::synth::modal {

namespace {

using Complex = std::complex<double>;

/// Share of the sum of all norms squared that rounding may hide.
constexpr double kRounding = 1e-9;

}  // namespace

Complex geometric_sum(const Complex& x, std::size_t count) {
  const auto n = static_cast<double>(count);
  const Complex denominator = expm1(x);
  if (denominator == 0.0) return n;
  return expm1(n * x) / denominator;
}

double product(const SampledPartial& a, const SampledPartial& b, std::size_t count) {
  // Re u Re v = Re(u v + u conj(v)) / 2.
  return (a.amplitude * b.amplitude * geometric_sum(a.step + b.step, count) +
          a.amplitude * std::conj(b.amplitude) * geometric_sum(a.step + std::conj(b.step), count))
             .real() /
         2;
}

NormBounds norm_of_sum(std::span<const SampledPartial> partials, std::size_t count) {
  if (count == 0) return {};
  // exp(step) and exp(count step) of each partial give those of every pair as products.
  std::vector<Complex> once, whole;
  for (const SampledPartial& p : partials) {
    once.push_back(std::exp(p.step));
    whole.push_back(std::exp(static_cast<double>(count) * p.step));
  }
  const auto sum = [&](const Complex& x, const Complex& one, const Complex& all) {
    // The products lose digits where x is small; there it is taken anew.
    return std::norm(1.0 - one) < 1e-4 ? geometric_sum(x, count) : (1.0 - all) / (1.0 - one);
  };
  double square = 0;
  double sizes = 0;
  for (std::size_t i = 0; i < partials.size(); ++i) {
    const SampledPartial& a = partials[i];
    double others = 0;
    for (std::size_t j = 0; j < i; ++j) {
      const SampledPartial& b = partials[j];
      const Complex with = sum(a.step + b.step, once[i] * once[j], whole[i] * whole[j]);
      const Complex against = sum(a.step + std::conj(b.step), once[i] * std::conj(once[j]),
                                  whole[i] * std::conj(whole[j]));
      others += (a.amplitude * (b.amplitude * with + std::conj(b.amplitude) * against)).real();
    }
    const double own = std::max(0.0, product(a, a, count));
    square += own + others;
    sizes += std::sqrt(own);
  }
  const double rounding = kRounding * sizes * sizes;
  return {std::sqrt(std::max(0.0, square - rounding)), std::sqrt(std::max(0.0, square) + rounding)};
}

}  // namespace carillon::synth::modal
