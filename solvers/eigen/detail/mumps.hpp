#pragma once

#include <mpi.h>

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>

#include "solvers/assembly/assemble.hpp"
#include "solvers/eigen/cholesky.hpp"

namespace carillon::solvers::eigen {

/// Signs of the pivots; Sylvester: those of the eigenvalues.
struct Inertia {
  std::int64_t negative = 0;
  std::int64_t zero = 0;
};

/// MUMPS' multifrontal factor of K - shift M (Amestoy, Duff, L'Excellent and Koster 2001), on any
/// number of ranks. Called without PETSc between, which would refuse an elimination order from
/// outside (Debian's MUMPS has no METIS of its own) and could not let the factor go.
class Mumps {
 public:
  enum class Purpose {
    solve,    ///< Cholesky of a positive definite matrix, kept
    inertia,  ///< L D L^T with pivoting; its entries are let go, which takes a quarter of the
              ///< memory
  };

  /// Analyses the structure.
  /// @param node_order  order[k]: node (by the partition's number) eliminated k-th, of the whole
  ///                    body; read on rank 0 alone
  /// @throws core::SolverError  MUMPS failed, or more entries on one rank than it can count
  /// @note Collective on comm, as are factor and solve.
  Mumps(const assembly::System& system, Purpose purpose, std::span<const std::int32_t> node_order,
        MPI_Comm comm);
  ~Mumps();
  Mumps(const Mumps&) = delete;
  Mumps& operator=(const Mumps&) = delete;

  /// As estimated by the analysis.
  FactorSize size() const;

  /// Workspace that turns out too small is doubled, at most three times. May be called once.
  /// @throws core::SolverError  singular, not positive definite, or out of memory
  void factor(double shift);

  /// Any number of right-hand sides, owned unknowns x columns.
  void solve(const Eigen::Ref<const Eigen::MatrixXd>& right,
             Eigen::Ref<Eigen::MatrixXd> solution) const;

  Inertia inertia() const;

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace carillon::solvers::eigen
