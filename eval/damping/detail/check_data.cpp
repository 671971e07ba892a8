#include "eval/damping/detail/check_data.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "eval/damping/detail/scaled_law.hpp"

namespace carillon::eval::damping {

namespace {

using core::InputError;

void check_value(const char* name, double value, std::size_t point) {
  if (std::isfinite(value) && value > 0) return;
  throw InputError(fmt::format("point {} of the damping data has {} = {}", point + 1, name, value),
                   "leave out what does not decay, and what could not be measured");
}

/// Eigenvalues that differ by more than rounding.
std::size_t different(std::vector<double> eigenvalues) {
  std::sort(eigenvalues.begin(), eigenvalues.end());
  std::size_t count = eigenvalues.empty() ? 0 : 1;
  double last = eigenvalues.empty() ? 0 : eigenvalues.front();
  for (const double value : eigenvalues) {
    if (value > last * (1 + 1e-9)) {
      ++count;
      last = value;
    }
  }
  return count;
}

}  // namespace

void check_data(const DampingData& data, const DampingLaw& law, Estimator estimator) {
  if (data.coefficients.size() != data.size() ||
      (!data.errors.empty() && data.errors.size() != data.size())) {
    throw InputError(fmt::format("{} eigenvalues, but {} damping coefficients and {} errors",
                                 data.size(), data.coefficients.size(), data.errors.size()));
  }
  if (!data.proportions.empty() && data.proportions.size() != data.size()) {
    throw core::InputError(
        fmt::format("{} eigenvalues, but {} proportions", data.size(), data.proportions.size()));
  }
  if (!data.ceilings.empty() && data.ceilings.size() != data.size()) {
    throw InputError(
        fmt::format("{} eigenvalues, but {} ceilings", data.size(), data.ceilings.size()));
  }
  for (std::size_t i = 0; i < data.size(); ++i) {
    check_value("lambda", data.eigenvalues[i], i);
    check_value("c", data.coefficients[i], i);
    if (!data.ceilings.empty() && !(data.ceilings[i] >= data.coefficients[i])) {
      throw InputError(fmt::format("point {} of the damping data has c = {} above its ceiling {}",
                                   i + 1, data.coefficients[i], data.ceilings[i]));
    }
    if (data.errors.empty() || (std::isfinite(data.errors[i]) && data.errors[i] >= 0)) continue;
    throw InputError(
        fmt::format("point {} of the damping data has an error of {}", i + 1, data.errors[i]),
        "errors are standard deviations; leave all out where one is not known");
  }
  const std::size_t alphas = parameter_count(law);
  const std::size_t numbers = alphas + (has_excess(estimator) ? 2 : 0);
  const std::string name = synth::damping::form_of(law.kind).name;
  if (data.size() < numbers) {
    throw InputError(fmt::format("{} feature{}, but {} damping has {} parameter{}{}", data.size(),
                                 data.size() == 1 ? "" : "s", name, alphas, alphas == 1 ? "" : "s",
                                 has_excess(estimator) ? ", and sigma and eta are sought too" : ""),
                     has_excess(estimator)
                         ? "give more sounds, or use --estimator least_squares"
                         : "give more sounds, or --model caughey:1 for a constant");
  }
  if (const std::size_t places = different(data.eigenvalues); places < alphas) {
    throw InputError(fmt::format("features at {} frequenc{} only, but {} damping has {} parameters",
                                 places, places == 1 ? "y" : "ies", name, alphas),
                     "give more sounds, or --model caughey:1 for a constant");
  }
}

}  // namespace carillon::eval::damping
