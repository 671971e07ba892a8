#include "eval/damping/detail/emg.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <numbers>

namespace carillon::eval {
namespace {

constexpr double pi = std::numbers::pi;

struct Reference {
  double u, kappa, value, mu, sigma, exponential;
};
constexpr Reference references[] = {
#include "tests/eval/emg_reference.inc"
};

TEST(EmgDensity, IsThatOfEightyDigits) {
  for (const Reference& r : references) {
    const damping::EmgDensity density = damping::emg_log_density(r.u, 0, 1, r.kappa);
    const auto close = [&](double value, double expected, double tolerance) {
      EXPECT_NEAR(value, expected, tolerance * (1 + std::abs(expected)))
          << "u " << r.u << ", kappa " << r.kappa;
    };
    close(density.value, r.value, 1e-15);
    close(density.mu, r.mu, 1e-14);
    close(density.sigma, r.sigma, 1e-14);
    close(density.kappa, r.exponential, 1e-13);
  }
}

double any_kappa() {
  return std::pow(10, *rc::gen::inRange(-6000, 12000) * 1e-3);
}

double any_u() {
  return *rc::gen::inRange(-12000, 40000) * 1e-3;
}

TEST(EmgDensity, ScalesAndShifts) {
  EXPECT_TRUE(rc::check("units", [] {
    const double u = any_u(), kappa = any_kappa();
    const double mu = *rc::gen::inRange(-100, 100), sigma = *rc::gen::inRange(1, 1000) * 1e-2;
    const damping::EmgDensity standard = damping::emg_log_density(u, 0, 1, kappa);
    const damping::EmgDensity moved = damping::emg_log_density(mu + sigma * u, mu, sigma, kappa);
    const double rounding =
        1e-12 * (1 + std::abs(mu) / sigma) * (1 + u * u) * (1 + std::min(kappa, 1.0));
    RC_ASSERT(std::abs(moved.value + std::log(sigma) - standard.value) <= rounding);
    RC_ASSERT(std::abs(moved.mu * sigma - standard.mu) <= rounding);
  }));
}

// Central differences of values and of first derivatives.
TEST(EmgDensity, HasDerivativesOfItsDifferences) {
  EXPECT_TRUE(rc::check("derivatives", [] {
    const double u = any_u();
    const double kappa = std::pow(10, *rc::gen::inRange(-3000, 2000) * 1e-3);
    const double h = 1e-5;
    const auto at = [&](double mu, double log_sigma, double log_kappa) {
      return damping::emg_log_density(u, mu, std::exp(log_sigma), kappa * std::exp(log_kappa));
    };
    const damping::EmgDensity d = at(0, 0, 0);
    const auto near = [&](double up, double down, double slope) {
      // Third derivatives grow as u^2 does.
      const double tolerance = 1e-6 * (1 + u * u + std::abs(slope));
      RC_ASSERT(std::abs((up - down) / (2 * h) - slope) <= tolerance);
    };
    const damping::EmgDensity mu[] = {at(h, 0, 0), at(-h, 0, 0)};
    const damping::EmgDensity sigma[] = {at(0, h, 0), at(0, -h, 0)};
    const damping::EmgDensity exponential[] = {at(0, 0, h), at(0, 0, -h)};
    near(mu[0].value, mu[1].value, d.mu);
    near(sigma[0].value, sigma[1].value, d.sigma);
    near(exponential[0].value, exponential[1].value, d.kappa);
    near(mu[0].mu, mu[1].mu, d.mu_mu);
    near(sigma[0].mu, sigma[1].mu, d.mu_sigma);
    near(exponential[0].mu, exponential[1].mu, d.mu_kappa);
    near(sigma[0].sigma, sigma[1].sigma, d.sigma_sigma);
    near(sigma[0].kappa, sigma[1].kappa, d.sigma_kappa);
    near(exponential[0].kappa, exponential[1].kappa, d.kappa_kappa);
  }));
}

// The derivatives by mu, sigma and eta as published, with eta^2 where eq. 18 has lambda^2 and
// t_i = -2 / (sqrt(pi) erfcx(s_i)).
TEST(EmgDensity, HasThePapersGradient) {
  EXPECT_TRUE(rc::check("as published", [] {
    const double sigma = *rc::gen::inRange(200, 3000) * 1e-3;
    const double eta = *rc::gen::inRange(100, 2000) * 1e-3;
    const double rest = *rc::gen::inRange(-3000, 6000) * 1e-3;  // d - c
    const double s = (eta * sigma * sigma - rest) / (std::sqrt(2) * sigma);
    RC_PRE(std::abs(s) < 5);
    const double t = -2 / (std::sqrt(pi) * std::exp(s * s) * std::erfc(s));
    const double by_eta = 1 / eta + eta * sigma * sigma - rest + t * sigma / std::sqrt(2);
    const double by_sigma =
        eta * eta * sigma + t * (eta * sigma * sigma + rest) / (std::sqrt(2) * sigma * sigma);
    const double by_mu = eta + t / (std::sqrt(2) * sigma);
    const damping::EmgDensity d = damping::emg_log_density(rest, 0, sigma, eta * sigma);
    const auto near = [](double a, double b) {
      RC_ASSERT(std::abs(a - b) <= 1e-9 * (1 + std::abs(b)));
    };
    near(d.mu, by_mu);
    near(d.kappa / eta, by_eta);  // kappa = eta sigma
    near((d.sigma + d.kappa) / sigma, by_sigma);
  }));
}

TEST(EmgDensity, IntegratesToOne) {
  EXPECT_TRUE(rc::check("integral", [] {
    const double kappa = std::pow(10, *rc::gen::inRange(-2000, 6000) * 1e-3);
    const double high = 12 + 45 / kappa;
    const double step = std::min(0.02, high / 20000);
    double sum = 0;
    for (double u = -14; u < high; u += step)
      sum += std::exp(damping::emg_log_density(u, 0, 1, kappa).value);
    RC_ASSERT(std::abs(sum * step - 1) < 1e-9);
  }));
}

TEST(EmgDensity, EndsAsItsParts) {
  EXPECT_TRUE(rc::check("limits", [] {
    const double x = *rc::gen::inRange(1, 4000) * 1e-2;
    // The Gaussian vanishes: a shifted exponential of rate 0.3, and nothing below mu.
    const double sigma = 1e-9;
    const damping::EmgDensity thin = damping::emg_log_density(x, 0, sigma, 0.3 * sigma);
    RC_ASSERT(std::abs(thin.value - (std::log(0.3) - 0.3 * x)) < 1e-9);
    RC_ASSERT(damping::emg_log_density(-x, 0, sigma, 0.3 * sigma).value < -1e9);
    // The exponential vanishes: a normal distribution.
    const double u = x / 10;
    const damping::EmgDensity normal = damping::emg_log_density(u, 0, 1, 1e12);
    RC_ASSERT(std::abs(normal.value + u * u / 2 + 0.5 * std::log(2 * pi)) < 1e-10);
  }));
}

// What lets Newton's steps find the only maximum of a law linear in its alphas.
TEST(EmgDensity, IsConcaveInItsPlace) {
  EXPECT_TRUE(rc::check("concave", [] {
    const damping::EmgDensity density = damping::emg_log_density(any_u(), 0, 1, any_kappa());
    RC_ASSERT(density.mu_mu <= 0);
    RC_ASSERT(density.mu_mu >= -1 - 1e-12);
    RC_ASSERT(std::isfinite(density.kappa_kappa));
  }));
}

}  // namespace
}  // namespace carillon::eval
