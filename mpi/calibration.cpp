#include "mpi/calibration.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

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

EstimateError error_of(std::vector<double> ascending) {
  std::sort(ascending.begin(), ascending.end());
  constexpr double tail = 1.0 / 6;
  return {std::exp(quantile(ascending, 0.5)),
          std::exp(0.5 * (quantile(ascending, 1 - tail) - quantile(ascending, tail)))};
}

}  // namespace

double Calibration::Kind::median() const {
  return low.size() > high.size() ? *low.rbegin() : 0.5 * (*low.rbegin() + *high.begin());
}

void Calibration::Kind::add(double before) {
  const bool lower = low.empty() || before <= *low.rbegin();
  (lower ? low : high).insert(before);
  if (low.size() > high.size() + 1) high.insert(low.extract(std::prev(low.end())));
  if (high.size() > low.size()) low.insert(high.extract(high.begin()));
}

void Calibration::add(const std::string& kind, double estimate, double seconds) {
  if (!(estimate > 0) || !(seconds > 0)) return;
  const double ratio = std::log(seconds / estimate);
  const double corrected = ratio - std::log(factor(kind));
  kinds_[kind].add(ratio);
  kinds_[kind].after.push_back(corrected);
}

double Calibration::factor(const std::string& kind) const {
  const auto found = kinds_.find(kind);
  if (found == kinds_.end() || found->second.tasks() < least_tasks) return 1;
  return std::exp(found->second.median());
}

std::map<std::string, Calibration::Report> Calibration::report() const {
  std::map<std::string, Report> reports;
  for (const auto& [name, kind] : kinds_) {
    std::vector<double> before(kind.low.begin(), kind.low.end());
    before.insert(before.end(), kind.high.begin(), kind.high.end());
    reports[name] = {static_cast<std::int64_t>(kind.tasks()), error_of(std::move(before)),
                     error_of(kind.after)};
  }
  return reports;
}

}  // namespace carillon::mpi
