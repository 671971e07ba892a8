#pragma once

#include <span>
#include <vector>

#include "eval/features/feature.hpp"

namespace carillon::eval::damping {

/// Damping coefficients against eigenvalues: what damping models are fitted to.
struct DampingData {
  std::vector<double> eigenvalues;   ///< lambda [rad^2/s^2]
  std::vector<double> coefficients;  ///< c = 2 d [1/s]
  std::vector<double> errors;        ///< standard errors of c [1/s]; empty: unknown
  std::size_t size() const { return eigenvalues.size(); }
};

/// c = 2 d and lambda = omega_d^2 + d^2 of each feature; those marked as reverberant are left out.
DampingData damping_data(std::span<const features::Feature> features);

}  // namespace carillon::eval::damping
