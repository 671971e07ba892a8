#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/numbers.hpp"
#include "eval/damping/fit_damping.hpp"

namespace carillon::eval::material {

/// A damping law's parameters as they are searched: logarithms of those that are positive, the
/// others in units of their usual sizes.
struct LawSearch {
  damping::DampingLaw law;
  std::vector<bool> logarithmic;
  std::vector<double> sizes;

  std::vector<double> coordinates(std::span<const double> parameters) const;
  /// @param y  one coordinate for each parameter, or more
  std::vector<double> parameters(std::span<const double> y) const;
  double parameter(std::size_t k, double coordinate) const;
  /// c of the law at eigenvalues [1/s]; empty where it is not positive.
  std::vector<double> coefficients(std::span<const double> y,
                                   std::span<const double> eigenvalues) const;
};

/// @param start  parameters near those that are sought
LawSearch law_search(const damping::DampingData& data, const damping::DampingLaw& law,
                     std::span<const double> start);

using LawObjective = std::function<double(std::span<const double>)>;

/// Where the profile of one coordinate passes a limit; infinite where it never does.
/// @param objective  to be minimised over all coordinates
/// @param best       its minimum
/// @param limit      above the minimum's value
core::Range profile_range(const LawObjective& objective, const std::vector<double>& best,
                          std::size_t k, double limit);

}  // namespace carillon::eval::material
