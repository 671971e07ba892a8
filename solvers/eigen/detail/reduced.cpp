#include "solvers/eigen/detail/reduced.hpp"

#include "mpi/comm.hpp"
#include "solvers/dense/eigenpairs.hpp"

namespace carillon::solvers::eigen {
namespace {

int rank_of(MPI_Comm comm) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  return rank;
}

}  // namespace

void sum_alike(Eigen::MatrixXd& matrix, MPI_Comm comm) {
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  if (ranks == 1) return;
  // An Allreduce may add in another order on each rank.
  const auto count = static_cast<int>(matrix.size());
  if (rank_of(comm) == 0) {
    MPI_Reduce(MPI_IN_PLACE, matrix.data(), count, MPI_DOUBLE, MPI_SUM, 0, comm);
  } else {
    MPI_Reduce(matrix.data(), nullptr, count, MPI_DOUBLE, MPI_SUM, 0, comm);
  }
  share_first(matrix, comm);
}

void share_first(Eigen::MatrixXd& matrix, MPI_Comm comm) {
  MPI_Bcast(matrix.data(), static_cast<int>(matrix.size()), MPI_DOUBLE, 0, comm);
}

Eigen::VectorXd eigenpairs_alike(Eigen::MatrixXd& matrix, MPI_Comm comm) {
  Eigen::VectorXd values(matrix.rows());
  // LAPACK may take other instructions on other machines.
  mpi::agreed_in_group(comm, [&] {
    if (rank_of(comm) == 0) values = dense::symmetric_eigenpairs(matrix);
  });
  MPI_Bcast(values.data(), static_cast<int>(values.size()), MPI_DOUBLE, 0, comm);
  share_first(matrix, comm);
  return values;
}

}  // namespace carillon::solvers::eigen
