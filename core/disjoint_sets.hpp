#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace carillon::core {

/// The numbers 0 to n - 1 in sets that are joined two by two (union-find with path halving). The
/// lowest number names a set, so that names do not depend on the order of joining.
class DisjointSets {
 public:
  /// Each number in a set of its own.
  explicit DisjointSets(std::size_t count = 0) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }

  std::size_t size() const { return parent_.size(); }

  /// The lowest number of the set that holds `item`.
  std::size_t find(std::size_t item) {
    while (parent_[item] != item) item = parent_[item] = parent_[parent_[item]];
    return item;
  }

  void join(std::size_t a, std::size_t b) {
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::size_t> parent_;
};

}  // namespace carillon::core
