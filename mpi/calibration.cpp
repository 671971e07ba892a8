#include "mpi/calibration.hpp"

#include <algorithm>
#include <cmath>

namespace carillon::mpi {

namespace {

constexpr std::size_t least_tasks = 3;

/// Value below which a share of an ascending list lies, between neighbours in proportion.
double quantile(const std::vector<double>& ascending, double share) {
  const double place = share * static_cast<double>(ascending.size() - 1);
  const auto low = static_cast<std::size_t>(place);
  const std::size_t high = std::min(low + 1, ascending.size() - 1);
  return ascending[low] + (place - static_cast<double>(low)) * (ascending[high] - ascending[low]);
}

void insert(std::vector<double>& ascending, double value) {
  ascending.insert(std::upper_bound(ascending.begin(), ascending.end(), value), value);
}

EstimateError error_of(const std::vector<double>& ascending) {
  constexpr double tail = 1.0 / 6;
  return {std::exp(quantile(ascending, 0.5)),
          std::exp(0.5 * (quantile(ascending, 1 - tail) - quantile(ascending, tail)))};
}

}  // namespace

void Calibration::add(const std::string& kind, double estimate, double seconds) {
  if (!(estimate > 0) || !(seconds > 0)) return;
  const double ratio = std::log(seconds / estimate);
  const double corrected = ratio - std::log(factor(kind));
  insert(kinds_[kind].before, ratio);
  insert(kinds_[kind].after, corrected);
}

double Calibration::factor(const std::string& kind) const {
  const auto found = kinds_.find(kind);
  if (found == kinds_.end() || found->second.before.size() < least_tasks) return 1;
  return std::exp(quantile(found->second.before, 0.5));
}

std::map<std::string, Calibration::Report> Calibration::report() const {
  std::map<std::string, Report> reports;
  for (const auto& [name, kind] : kinds_) {
    reports[name] = {static_cast<std::int64_t>(kind.before.size()), error_of(kind.before),
                     error_of(kind.after)};
  }
  return reports;
}

}  // namespace carillon::mpi
