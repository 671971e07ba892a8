#include "eval/validation/estimator_errors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/error.hpp"
#include "core/numbers.hpp"

namespace carillon::eval::validation {

namespace {

/// What double precision cannot tell from no error at all, in place of the logarithm of zero.
constexpr double min_error = std::numeric_limits<double>::epsilon();

}  // namespace

ErrorSummary summarise_errors(std::span<const double> errors, core::RandomStream& random) {
  std::vector<double> found, sizes;
  for (const double error : errors) {
    if (!std::isfinite(error)) continue;
    found.push_back(error);
    sizes.push_back(std::abs(error));
  }
  const auto middle = [](std::span<const double> values) {
    return core::median({values.begin(), values.end()});
  };
  ErrorSummary summary;
  summary.fits = errors.size();
  summary.failed = errors.size() - found.size();
  summary.median = core::median(sizes);
  summary.median95 = statistics::bootstrap(sizes, middle, random);
  summary.mean = statistics::mean(sizes);
  summary.lower_quartile = core::quantile(sizes, 0.25);
  summary.upper_quartile = core::quantile(sizes, 0.75);
  summary.bias = core::median(found);
  return summary;
}

EstimatorComparison compare_errors(std::span<const double> a, std::span<const double> b) {
  if (a.size() != b.size()) {
    throw core::InputError(
        fmt::format("{} and {} fits are not of the same draws", a.size(), b.size()));
  }
  std::vector<double> first, second, differences, first_log, second_log;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!std::isfinite(a[i]) || !std::isfinite(b[i])) continue;
    first.push_back(std::abs(a[i]));
    second.push_back(std::abs(b[i]));
    differences.push_back(first.back() - second.back());
    first_log.push_back(std::log(std::max(first.back(), min_error)));
    second_log.push_back(std::log(std::max(second.back(), min_error)));
  }
  return {first.size(), core::median(differences), statistics::signed_rank_test(first, second),
          statistics::welch_test(first_log, second_log)};
}

}  // namespace carillon::eval::validation
