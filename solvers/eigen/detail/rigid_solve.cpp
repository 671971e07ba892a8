#include "solvers/eigen/detail/rigid_solve.hpp"

namespace carillon::solvers::eigen {

RigidSolve::RigidSolve(const mesh::TetMesh& mesh, const assembly::System& system,
                       const std::vector<std::int32_t>& component, double shift, MPI_Comm comm)
    : motions_(system.owned_unknowns(), 6), comm_(comm) {
  const RigidMotions motions(mesh, system, component);
  for (std::int32_t row = 0; row < system.graph.rows(); ++row) {
    const auto number = static_cast<std::size_t>(system.graph.begin + row);
    const auto node = static_cast<std::size_t>(system.partition.node[number]);
    motions_.middleRows<3>(3 * row) = motions.at(node);
    first_.push_back(motions.first_of(node));
  }
  count_ = motions.count();
  factor_.compute(-shift * gram_matrix(system, motions, comm));
}

void RigidSolve::add(const Eigen::Ref<const Eigen::MatrixXd>& right,
                     Eigen::Ref<Eigen::MatrixXd> solution) const {
  Eigen::MatrixXd projected = Eigen::MatrixXd::Zero(count_, right.cols());
  for (std::size_t n = 0; n < first_.size(); ++n) {
    const auto row = 3 * static_cast<Eigen::Index>(n);
    projected.middleRows<6>(first_[n]).noalias() +=
        motions_.middleRows<3>(row).transpose() * right.middleRows<3>(row);
  }
  MPI_Allreduce(MPI_IN_PLACE, projected.data(), static_cast<int>(projected.size()), MPI_DOUBLE,
                MPI_SUM, comm_);
  projected = factor_.solve(projected).eval();
  for (std::size_t n = 0; n < first_.size(); ++n) {
    const auto row = 3 * static_cast<Eigen::Index>(n);
    solution.middleRows<3>(row).noalias() +=
        motions_.middleRows<3>(row) * projected.middleRows<6>(first_[n]);
  }
}

}  // namespace carillon::solvers::eigen
