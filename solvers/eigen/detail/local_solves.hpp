#pragma once

#include <cstdint>
#include <vector>

#include "solvers/eigen/detail/finer_space.hpp"

namespace carillon::solvers::eigen {

/// Overlapping additive Schwarz: for each element of a finer space the assembled matrix A on the
/// element's nodes is solved. Blocks of this size reach over the thickness of a flat element, where
/// single nodes would not do. In single precision: it only guides the iteration.
class LocalSolves {
 public:
  /// `space` is kept by reference.
  explicit LocalSolves(const FinerSpace& space);

  /// What the blocks of so many elements take.
  /// @param order  of the finer space
  static std::int64_t bytes(std::size_t elements, int order);

  /// Adds this rank's blocks' part; a node's share in each of its blocks is one over their number
  /// (half of that power on the way in, half on the way out, so that it stays symmetric).
  void add(const Fields& residual, Fields& out) const;

 private:
  const FinerSpace& space_;
  Eigen::Index size_;          ///< unknowns of a block
  std::vector<float> blocks_;  ///< lower Cholesky factors, one block after the other
  std::vector<float> share_;   ///< of a node
};

}  // namespace carillon::solvers::eigen
