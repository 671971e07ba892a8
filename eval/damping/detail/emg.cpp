#include "eval/damping/detail/emg.hpp"

#include <cmath>
#include <numbers>

namespace carillon::eval::damping {

namespace {

constexpr double sqrt_2 = std::numbers::sqrt2;
constexpr double inv_sqrt_pi = std::numbers::inv_sqrtpi;

/// ln(kappa / 2) + ln of the density without its Gaussian or exponential factor, and the first two
/// derivatives of ln erfcx.
struct Tail {
  double log = 0;
  double slope = 0;      ///< h = d ln erfcx / dz
  double bend = 0;       ///< h'
  double bend_less = 0;  ///< h' / 2 - 1, which h' would lose to rounding where z < 0
  double log_slope = 0;  ///< g = -d ln erfc / dz = 2 z - h
};

/// erfcx(z) sqrt(pi) z = 1 - i/2 (1 - 3 i/2 (1 - 5 i/2 ...)), i = 1 / z^2: at z >= 12 what follows
/// the tenth term is below 1e-16.
Tail far_tail(double z, double kappa) {
  const double i = 1 / (z * z);
  double series = 1, first = 0, second = 0;  // and derivatives by i
  for (int k = 10; k >= 1; --k) {
    const double factor = -(k - 0.5);
    second = factor * (2 * first + i * second);
    first = factor * (series + i * first);
    series = 1 + factor * i * series;
  }
  Tail tail;
  tail.log = std::log(kappa * inv_sqrt_pi / (2 * z) * series);
  // s = ln series: d/dz = -2 i / z d/di.
  const double s1 = first / series;
  const double s2 = second / series - s1 * s1;
  tail.slope = -(1 + 2 * i * s1) / z;
  tail.bend = i * (1 + 6 * i * s1 + 4 * i * i * s2);
  tail.bend_less = tail.bend / 2 - 1;
  tail.log_slope = 2 * z - tail.slope;
  return tail;
}

Tail near_tail(double z, double kappa) {
  // exp(z^2) with what rounding takes off the square: erfcx to a few units in the last place.
  const double square = z * z;
  const double rest = std::fma(z, z, -square);
  const double complement = std::erfc(z);
  Tail tail;
  if (z < 0) {
    tail.log = std::log(kappa / 2 * complement);
    tail.log_slope = 2 * inv_sqrt_pi * std::exp(-square) * (1 - rest) / complement;
  } else {
    const double scaled = std::exp(square) * (1 + rest) * complement;
    tail.log = std::log(kappa / 2 * scaled);
    tail.log_slope = 2 * inv_sqrt_pi / scaled;
  }
  tail.slope = 2 * z - tail.log_slope;
  tail.bend_less = tail.log_slope * tail.slope / 2;
  tail.bend = 2 + 2 * tail.bend_less;
  return tail;
}

}  // namespace

EmgDensity emg_log_density(double x, double mu, double sigma, double kappa) {
  constexpr double far = 12;
  const double u = (x - mu) / sigma;
  const double z = (kappa - u) / sqrt_2;
  const Tail tail = z >= far ? far_tail(z, kappa) : near_tail(z, kappa);

  // Derivatives of L = ln(sigma density) - ln(kappa / 2) with respect to u and kappa.
  const bool gaussian = z >= 0;
  const double l = gaussian ? -u * u / 2 : kappa * (kappa / 2 - u);
  const double l_u = gaussian ? -u - tail.slope / sqrt_2 : -kappa + tail.log_slope / sqrt_2;
  const double l_kappa = gaussian ? tail.slope / sqrt_2 : kappa - u - tail.log_slope / sqrt_2;
  const double l_uu = tail.bend_less;
  const double l_kappa_kappa = tail.bend / 2;
  const double l_u_kappa = -l_kappa_kappa;

  EmgDensity density;
  density.value = l + tail.log - std::log(sigma);
  density.mu = -l_u / sigma;
  density.sigma = -1 - u * l_u;
  density.kappa = 1 + kappa * l_kappa;
  density.mu_mu = l_uu / (sigma * sigma);
  density.mu_sigma = (l_u + u * l_uu) / sigma;
  density.mu_kappa = -kappa * l_u_kappa / sigma;
  density.sigma_sigma = u * (l_u + u * l_uu);
  density.sigma_kappa = -u * kappa * l_u_kappa;
  density.kappa_kappa = kappa * (l_kappa + kappa * l_kappa_kappa);
  return density;
}

}  // namespace carillon::eval::damping
