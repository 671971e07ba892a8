#pragma once

namespace carillon::eval::damping {

/// ln of the density of an exponentially modified Gaussian, with its derivatives with respect to
/// mu, ln sigma and ln kappa, where kappa = eta sigma is the Gaussian's width in units of the
/// exponential's.
struct EmgDensity {
  double value = 0;
  double mu = 0, sigma = 0, kappa = 0;  ///< first derivatives; by ln sigma at a fixed kappa
  double mu_mu = 0, mu_sigma = 0, mu_kappa = 0;
  double sigma_sigma = 0, sigma_kappa = 0, kappa_kappa = 0;
};

/// Density at x of mu + N(0, sigma^2) + Exp(rate eta), eta = kappa / sigma (Sterling 2019, eq. 4.7;
/// the article's 12). Relative error below 1e-13 for any kappa > 0, sigma > 0: a normal
/// distribution for large kappa, a shifted exponential for small.
///
/// With u = (x - mu) / sigma and z = (kappa - u) / sqrt(2) it is, in the form that neither
/// overflows nor cancels,
///   ln(kappa / (2 sigma)) - u^2 / 2 + ln erfcx(z)               for z >= 0 and
///   ln(kappa / (2 sigma)) - kappa u + kappa^2 / 2 + ln erfc(z)  for z < 0
/// (Kalambet et al. 2011, J. Chemometrics 25, 352).
EmgDensity emg_log_density(double x, double mu, double sigma, double kappa);

}  // namespace carillon::eval::damping
