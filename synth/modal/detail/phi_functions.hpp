#pragma once

#include <cmath>
#include <complex>

namespace carillon::synth::modal {

/// exp(z) - 1 without cancellation for small z.
inline std::complex<double> expm1(const std::complex<double>& z) {
  const double half_sine = std::sin(z.imag() / 2);
  return {std::expm1(z.real()) * std::cos(z.imag()) - 2 * half_sine * half_sine,
          std::exp(z.real()) * std::sin(z.imag())};
}

/// (exp(z) - 1) / z.
inline std::complex<double> phi1(const std::complex<double>& z) {
  return z == 0.0 ? std::complex<double>(1) : expm1(z) / z;
}
inline double phi1(double x) {
  return x == 0 ? 1 : std::expm1(x) / x;
}

/// (exp(x) - 1 - x) / x^2, x <= 0.
inline double phi2(double x) {
  if (x < -0.5) return (phi1(x) - 1) / x;
  double sum = 0;
  for (int n = 16; n >= 2; --n) sum = (1 + x * sum) / n;
  return sum;
}

}  // namespace carillon::synth::modal
