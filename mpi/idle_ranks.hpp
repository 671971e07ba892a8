#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace carillon::mpi {

/// How many ranks had no task, and when: from the end of their last one until they got another,
/// where they were told to wait or that nothing is left.
class IdleRanks {
 public:
  void add(int ranks, double time) { changes_.push_back({time, ranks}); }

  struct Moments {
    double all_until = 0, half_until = 0;
  };
  /// The last moments when no rank, and at most half of them, were idle.
  Moments moments(int ranks) {
    std::sort(changes_.begin(), changes_.end());
    Moments out;
    int idle = 0;
    for (std::size_t i = 0; i < changes_.size();) {
      const double time = changes_[i].first;
      const int before = idle;
      // What happens at one time counts together: a rank may hand its place to another.
      for (; i < changes_.size() && changes_[i].first == time; ++i) idle += changes_[i].second;
      if (before == 0 && idle > 0) out.all_until = time;
      if (2 * before <= ranks && 2 * idle > ranks) out.half_until = time;
    }
    return out;
  }

 private:
  std::vector<std::pair<double, int>> changes_;
};

}  // namespace carillon::mpi
