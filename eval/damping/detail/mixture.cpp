#include "eval/damping/detail/mixture.hpp"

#include <cmath>
#include <numbers>

#include "eval/damping/detail/emg.hpp"

namespace carillon::eval::damping {

namespace {

using Mixture = MixtureJet;

Mixture number(double value, int place) {
  return Mixture::variable(value, place);
}

Mixture fixed(double value) {
  return Mixture::constant(value);
}

/// ln of an EMG's density at c; sigma and kappa by their logarithms.
Mixture emg_jet(double c, const Mixture& m, const Mixture& log_sigma, const Mixture& log_kappa) {
  const EmgDensity f =
      emg_log_density(c, m.value, std::exp(log_sigma.value), std::exp(log_kappa.value));
  Mixture jet{f.value};
  jet.first = f.mu * m.first + f.sigma * log_sigma.first + f.kappa * log_kappa.first;
  const auto pair = [](const Mixture& a, const Mixture& b) {
    return (a.first * b.first.transpose() + b.first * a.first.transpose()).eval();
  };
  jet.second = f.mu * m.second + f.sigma * log_sigma.second + f.kappa * log_kappa.second +
               0.5 * (f.mu_mu * pair(m, m) + f.sigma_sigma * pair(log_sigma, log_sigma) +
                      f.kappa_kappa * pair(log_kappa, log_kappa)) +
               f.mu_sigma * pair(m, log_sigma) + f.mu_kappa * pair(m, log_kappa) +
               f.sigma_kappa * pair(log_sigma, log_kappa);
  return jet;
}

/// The standard normal distribution's function.
Mixture normal_below(const Mixture& u) {
  const double density =
      std::exp(-u.value * u.value / 2) * std::numbers::inv_sqrtpi / std::numbers::sqrt2;
  return chained(u, std::erfc(-u.value / std::numbers::sqrt2) / 2, density, -u.value * density);
}

/// What the density is made of.
struct Parts {
  Mixture m, log_sigma, log_means[2], log_shares[2];

  Parts(const Observed& observed, double law, const Eigen::Vector4d& numbers) {
    using namespace mixture_place;
    const double error = observed.error;
    m = number(law, mixture_place::law);
    const Mixture own = number(numbers[0], sigma);
    const double known = observed.proportion;
    const Mixture log_proportion =
        log(m) + (known > 0 ? 0.5 * log_sum(2 * own, fixed(2 * std::log(known))) : own);
    log_sigma =
        error > 0 ? 0.5 * log_sum(2 * log_proportion, fixed(2 * std::log(error))) : log_proportion;
    log_means[0] = number(numbers[1], touched);
    log_means[1] = number(numbers[2], spared);
    const Mixture logit = number(numbers[3], share);
    log_shares[0] = -1.0 * log_sum(fixed(0), -1.0 * logit);
    log_shares[1] = -1.0 * log_sum(fixed(0), logit);
  }

  Mixture log_inlier(double c) const {
    const auto part = [&](int k) {
      return log_shares[k] + emg_jet(c, m, log_sigma, log_sigma - log_means[k]);
    };
    return fixed(std::log1p(-outlier_share)) + log_sum(part(0), part(1));
  }

  Mixture log_outlier(double c) const {
    return fixed(std::log(outlier_share)) + log(m) - 2 * log(m + fixed(c));
  }

  /// ln of the probability of what lies below a ceiling: F = Phi(u) - f / eta for each EMG.
  Mixture log_below(double ceiling) const {
    const Mixture u = (fixed(ceiling) - m) * exp(-1.0 * log_sigma);
    Mixture below = outlier_share * ceiling * exp(-1.0 * log(m + fixed(ceiling)));
    for (int k = 0; k < 2; ++k) {
      const Mixture tail =
          exp(log_means[k] + emg_jet(ceiling, m, log_sigma, log_sigma - log_means[k]));
      below = below + (1 - outlier_share) * (exp(log_shares[k]) * (normal_below(u) - tail));
    }
    return log(below);
  }
};

}  // namespace

MixtureJet mixture_log_density(const Observed& observed, double m, const Eigen::Vector4d& numbers) {
  const Parts parts(observed, m, numbers);
  const Mixture inlier = parts.log_inlier(observed.c), outlier = parts.log_outlier(observed.c);
  // Far below the law an inlier's logarithm and its derivatives overflow.
  const bool beyond = !(inlier.value > outlier.value - 700);
  const Mixture density = beyond ? outlier : log_sum(inlier, outlier);
  return std::isfinite(observed.ceiling) ? density - parts.log_below(observed.ceiling) : density;
}

double outlier_probability(const Observed& observed, double m, const Eigen::Vector4d& numbers) {
  const Parts parts(observed, m, numbers);
  const double outlier = parts.log_outlier(observed.c).value;
  return 1 / (1 + std::exp(parts.log_inlier(observed.c).value - outlier));
}

}  // namespace carillon::eval::damping
