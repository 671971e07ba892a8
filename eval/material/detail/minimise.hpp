#pragma once

#include <functional>
#include <span>
#include <vector>

namespace carillon::eval::material {

struct Minimum {
  std::vector<double> x;
  double value = 0;
  int evaluations = 0;
  bool converged = false;  ///< not ended by the number of evaluations
};

/// A local minimum without derivatives by the subplex method, Nelder and Mead's simplex in
/// subspaces (Rowan 1990; NLopt's LN_SBPLX). Deterministic. Ends when a step gains less than
/// `tolerance` of the value.
/// @param function  finite everywhere; what it throws is thrown
/// @param steps     first steps, one for each coordinate
/// @throws SolverError  the optimiser failed
Minimum minimise(const std::function<double(std::span<const double>)>& function,
                 std::vector<double> start, std::span<const double> steps, double tolerance,
                 int max_evaluations);

}  // namespace carillon::eval::material
