#pragma once

#include <mpi.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "solvers/eigen/detail/finer_space.hpp"
#include "solvers/eigen/factor.hpp"

namespace carillon::solvers::eigen {

/// Whether more than a tenth of the body is in flat elements, whose longest edge is more than
/// six times the least altitude.
bool is_flat(const mesh::TetMesh& mesh);

/// The next order's own factor of A. Iterations that know single elements and the solved order see
/// next to nothing of how flat elements bend; where they do, only this tells what an order misses.
class FinerFactor {
 public:
  /// @param memory  [byte] for all ranks together
  /// @return nothing where the factor would take more
  /// @note Collective.
  static std::optional<FinerFactor> make(const FinerSpace& space,
                                         std::span<const elements::Elastic> regions,
                                         const assembly::MirrorClass& mirror, double shift,
                                         std::int64_t memory, MPI_Comm comm);

  /// Adds this rank's rows of A^-1 residual.
  /// @note Collective.
  void add(const Fields& residual, Fields& out) const;

 private:
  std::shared_ptr<const assembly::System> system_;  ///< the inverse refers to it
  Inverse inverse_;
};

}  // namespace carillon::solvers::eigen
