#pragma once

#include "eval/damping/fit_damping.hpp"

namespace carillon::eval::damping {

/// Numbers that an estimator has found: the alphas, and sigma and eta as far as it has them.
std::size_t fitted_numbers(const DampingFit& fit);

/// Akaike's criterion for small samples, 2 k - 2 ln L + 2 k (k + 1) / (n - k - 1) (Hurvich and Tsai
/// 1989): of two estimators on the same data, the lower one explains them better for the numbers
/// that it takes. Infinite where n <= k + 1.
double akaike(const DampingFit& fit);
/// Schwarz's (Bayesian) criterion k ln n - 2 ln L.
double bayesian(const DampingFit& fit);

}  // namespace carillon::eval::damping
