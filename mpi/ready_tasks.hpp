#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <limits>
#include <vector>

namespace carillon::mpi {

/// Which of some tasks in a fixed order are ready, and what memory they want: a tree of least
/// memories over their places. Putting in, taking out and finding are O(log n).
class ReadyTasks {
 public:
  explicit ReadyTasks(std::size_t places = 0)
      : leaves_(std::bit_ceil(std::max<std::size_t>(places, 1))), min_(2 * leaves_, nothing) {}

  void put(std::size_t place, double memory) { set(place, memory); }
  void take(std::size_t place) { set(place, nothing); }

  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
  /// The first place whose task fits; `none` where there is no such.
  /// @param fits  of memory [byte]; what fits, fits with less too
  template <class Fits>
  std::size_t first(const Fits& fits) const {
    const auto has_one = [&](std::size_t node) {
      return min_[node] != nothing && fits(min_[node]);
    };
    if (!has_one(1)) return none;
    std::size_t node = 1;
    while (node < leaves_) node = has_one(2 * node) ? 2 * node : 2 * node + 1;
    return node - leaves_;
  }

 private:
  static constexpr double nothing = std::numeric_limits<double>::infinity();

  void set(std::size_t place, double memory) {
    std::size_t node = leaves_ + place;
    min_[node] = memory;
    while (node > 1) {
      node /= 2;
      min_[node] = std::min(min_[2 * node], min_[2 * node + 1]);
    }
  }

  std::size_t leaves_;
  std::vector<double> min_;  ///< node n has the children 2 n and 2 n + 1, the root is 1
};

}  // namespace carillon::mpi
