#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>

#include "solvers/assembly/assemble.hpp"

namespace carillon::solvers::eigen {

/// What a factor takes, known before it is made.
struct FactorSize {
  std::int64_t entries = 0;  ///< in the factor, of all ranks together
  /// Most memory in use at one time while it is made, of all ranks together, beside the System.
  std::int64_t bytes = 0;
};

/// Structure of the Cholesky factor of K - shift M, the same for every shift: supernodes found by
/// CHOLMOD under a given elimination order (Chen, Davis, Hager and Rajamanickam 2008). One rank.
class CholeskyStructure {
 public:
  /// @param node_order  order[k]: node eliminated k-th, as from nested_dissection
  /// @throws core::SolverError  out of memory
  CholeskyStructure(const assembly::NodeGraph& graph, std::span<const std::int32_t> node_order);
  ~CholeskyStructure();
  CholeskyStructure(const CholeskyStructure&) = delete;
  CholeskyStructure& operator=(const CholeskyStructure&) = delete;

  FactorSize size() const;

 private:
  friend class Cholesky;
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

/// Supernodal Cholesky factor of K - shift M for a negative shift, on one rank. Indices have 64
/// bits, so memory alone bounds its size; the matrix itself is let go once it is factored.
class Cholesky {
 public:
  /// @throws core::SolverError  not positive definite, or out of memory
  Cholesky(const assembly::System& system, double shift, const CholeskyStructure& structure);
  ~Cholesky();
  Cholesky(const Cholesky&) = delete;
  Cholesky& operator=(const Cholesky&) = delete;

  /// Any number of right-hand sides, unknowns x columns: the factor is read once for all of them.
  void solve(const Eigen::Ref<const Eigen::MatrixXd>& right,
             Eigen::Ref<Eigen::MatrixXd> solution) const;

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace carillon::solvers::eigen
