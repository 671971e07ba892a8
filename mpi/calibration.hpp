#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace carillon::mpi {

/// How far estimates of one kind of task are off: measured over estimated seconds.
struct EstimateError {
  double median = 1;  ///< of the ratios
  double spread = 1;  ///< factor around the median that holds the middle two thirds of them
};

/// Estimated seconds against measured ones, kind by kind. The median of the logarithms is robust:
/// a task that hung, or was found done in a cache, moves it little. A task costs O(log n).
class Calibration {
 public:
  /// @param estimate  [s] as estimated before the run; ignored unless it and `seconds` are positive
  /// @param seconds   measured
  void add(const std::string& kind, double estimate, double seconds);
  /// What to multiply estimates of a kind with: the median ratio once three tasks have ended, 1
  /// before.
  double factor(const std::string& kind) const;

  struct Report {
    std::int64_t tasks = 0;
    EstimateError before;  ///< of the estimates as they were made
    EstimateError after;   ///< of the estimates times the factor of the moment a task ended
  };
  std::map<std::string, Report> report() const;

 private:
  /// Logarithms of ratios.
  struct Kind {
    std::multiset<double> low, high;  ///< before correction: the lower half, perhaps one more
    std::vector<double> after;
    std::size_t tasks() const { return low.size() + high.size(); }
    double median() const;
    void add(double before);
  };
  std::map<std::string, Kind> kinds_;
};

}  // namespace carillon::mpi
