#include "solvers/eigen/detail/multigrid.hpp"

#include "solvers/eigen/detail/algebraic_multigrid.hpp"
#include "solvers/eigen/detail/rigid.hpp"

namespace carillon::solvers::eigen {
namespace {

/// Degree of the smoothing polynomial: one more costs two products by cycle.
constexpr int smoothing_degree = 4;

/// A column of a matrix as PETSc's vector.
VecHandle wrap(const double* values, Eigen::Index rows, MPI_Comm comm) {
  VecHandle out;
  libraries::check(VecCreateMPIWithArray(comm, 3, static_cast<PetscInt>(rows), PETSC_DETERMINE,
                                         values, out.put()));
  return out;
}

}  // namespace

Multigrid::Multigrid(const mesh::TetMesh& body, std::span<const elements::Elastic> regions,
                     const assembly::System& body_system, double shift, std::int64_t factor_bytes,
                     MPI_Comm comm)
    : system_(body_system), comm_(comm) {
  const mesh::TetMesh* coarsest = &body;
  while (coarsest->order > 1) {
    const auto& finer = system(levels() - 1);
    smoothers_.push_back(std::make_unique<Smoother>(finer, shift, smoothing_degree, comm));
    const int order = coarsest->order > 2 ? 2 : 1;
    coarser_.push_back(
        std::make_unique<PLevel>(coarsen(body, regions, *coarsest, finer.partition, order, comm)));
    coarsest = &coarser_.back()->mesh;
    const auto& equations = coarser_.back()->system;
    const auto plan = plan_factors(equations, comm);
    const auto size = predict_factor(equations, FactorPurpose::solve, plan, comm);
    if (size.bytes <= factor_bytes) {
      factor_bytes_ = size.bytes;
      coarsest_ = factored_inverse(equations, shift, plan, comm);
      return;
    }
  }
  const auto& equations = system(levels() - 1);
  const auto parts = mesh::node_components(*coarsest);
  const RigidMotions motions(*coarsest, equations, parts);
  coarsest_ = algebraic_multigrid_cycle(equations, motions, shift, comm);
}

const assembly::System& Multigrid::system(std::size_t level) const {
  return level == 0 ? system_ : coarser_[level - 1]->system;
}

void Multigrid::cycle(std::size_t level, const Eigen::Ref<const Eigen::MatrixXd>& right,
                      Eigen::Ref<Eigen::MatrixXd> solution) const {
  if (level == smoothers_.size()) {
    coarsest_(right, solution);
    return;
  }
  const auto& smoother = *smoothers_[level];
  smoother.smooth(right, solution);
  Eigen::MatrixXd residual(right.rows(), right.cols());
  smoother.multiply(solution, residual);
  residual = right - residual;
  const auto coarse_right = restriction(level, residual);
  Eigen::MatrixXd coarse_solution(coarse_right.rows(), coarse_right.cols());
  cycle(level + 1, coarse_right, coarse_solution);
  solution += prolong(level, coarse_solution);
  smoother.multiply(solution, residual);
  residual = right - residual;
  Eigen::MatrixXd correction(right.rows(), right.cols());
  smoother.smooth(residual, correction);
  solution += correction;
}

Eigen::MatrixXd Multigrid::prolong(std::size_t level,
                                   const Eigen::Ref<const Eigen::MatrixXd>& coarse) const {
  Eigen::MatrixXd fine(system(level).owned_unknowns(), coarse.cols());
  for (Eigen::Index k = 0; k < coarse.cols(); ++k) {
    libraries::check(MatMult(coarser_[level]->prolongation.get(),
                             wrap(coarse.col(k).data(), coarse.rows(), comm_).get(),
                             wrap(fine.col(k).data(), fine.rows(), comm_).get()));
  }
  return fine;
}

Eigen::MatrixXd Multigrid::restriction(std::size_t level,
                                       const Eigen::Ref<const Eigen::MatrixXd>& fine) const {
  Eigen::MatrixXd coarse(system(level + 1).owned_unknowns(), fine.cols());
  for (Eigen::Index k = 0; k < fine.cols(); ++k) {
    libraries::check(MatMultTranspose(coarser_[level]->prolongation.get(),
                                      wrap(fine.col(k).data(), fine.rows(), comm_).get(),
                                      wrap(coarse.col(k).data(), coarse.rows(), comm_).get()));
  }
  return coarse;
}

}  // namespace carillon::solvers::eigen
