#pragma once

#include <mpi.h>

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "solvers/assembly/assemble.hpp"

namespace carillon::solvers::assembly {

/// K and M times blocks of columns that are zero where unknowns are held, straight from a System's
/// rows: no second copy of the matrices, and each entry is read once for eight columns.
class Products {
 public:
  /// @param system  is referred to, not copied
  /// @note Collective on comm, as are the products.
  Products(const System& system, MPI_Comm comm);

  /// M x. Owned unknowns x columns.
  void mass(const Eigen::Ref<const Eigen::MatrixXd>& x, Eigen::Ref<Eigen::MatrixXd> out) const;
  /// (K - shift M) x. Owned unknowns x columns.
  void shifted(double shift, const Eigen::Ref<const Eigen::MatrixXd>& x,
               Eigen::Ref<Eigen::MatrixXd> out) const;

 private:
  template <int Width, class Multiply>
  void block(const Eigen::Ref<const Eigen::MatrixXd>& x, Eigen::Index first,
             Eigen::Ref<Eigen::MatrixXd> out, Multiply multiply) const;
  template <int Width>
  void exchange(std::vector<double>& values) const;

  const System& system_;
  MPI_Comm comm_;
  /// Where the node of each graph.column lies among own nodes and, after them, those of others.
  std::vector<std::int32_t> place_;
  std::int32_t from_others_ = 0;
  std::vector<std::int32_t> to_send_;  ///< own rows, by the rank that wants them
  std::vector<int> send_counts_, receive_counts_;
};

}  // namespace carillon::solvers::assembly
