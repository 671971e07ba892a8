#include "mpi/calibration.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/numbers.hpp"

namespace carillon::mpi {

namespace {

constexpr std::size_t min_tasks = 3;

EstimateError error_of(const std::vector<double>& ratios) {
  constexpr double tail = 1.0 / 6;
  return {std::exp(core::median(ratios)),
          std::exp(0.5 * (core::quantile(ratios, 1 - tail) - core::quantile(ratios, tail)))};
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
  if (found == kinds_.end() || found->second.tasks() < min_tasks) return 1;
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
