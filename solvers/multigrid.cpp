#include "solvers/multigrid.hpp"

#include <optional>

#include "solvers/algebraic_multigrid.hpp"
#include "solvers/rigid.hpp"

namespace carillon::solvers {
namespace {

/// Degree of the smoothing polynomial: one more costs two products by cycle.
constexpr int smoothing_degree = 4;

/// A column of a matrix as PETSc's vector.
VecHandle wrap(const Eigen::Ref<const Eigen::VectorXd>& column, MPI_Comm comm) {
  VecHandle out;
  check(VecCreateMPIWithArray(comm, 3, static_cast<PetscInt>(column.size()), PETSC_DETERMINE,
                              column.data(), out.put()));
  return out;
}

/// A level's equations factored, if that takes no more memory than is given.
std::optional<Inverse> factor_within(const System& system, double shift, std::int64_t bytes,
                                     MPI_Comm comm) {
  const auto plan = plan_factors(system, comm);
  if (predict_factor(system, FactorPurpose::solve, plan, comm).bytes > bytes) return std::nullopt;
  return factored_inverse(system, shift, plan, comm);
}

}  // namespace

Multigrid::Multigrid(const TetMesh& body, std::span<const Elastic> regions,
                     const System& body_system, double shift, std::int64_t factor_bytes,
                     MPI_Comm comm)
    : mesh_(body), system_(body_system), comm_(comm) {
  for (std::size_t level = 0; mesh(level).order > 1; ++level) {
    smoothers_.push_back(std::make_unique<Smoother>(system(level), shift, smoothing_degree, comm));
    const int order = mesh(level).order > 2 ? 2 : 1;
    coarser_.push_back(std::make_unique<PLevel>(
        coarsen(body, regions, mesh(level), system(level).partition, order, comm)));
    const auto direct = factor_within(coarser_.back()->system, shift, factor_bytes, comm);
    if (direct) {
      coarsest_ = *direct;
      return;
    }
  }
  const auto& coarsest = mesh(levels() - 1);
  const auto parts = node_components(coarsest);
  const auto& equations = system(levels() - 1);
  const RigidMotions motions(coarsest, equations.scales, parts);
  coarsest_ = algebraic_multigrid_cycle(equations, motions, shift, comm);
}

const TetMesh& Multigrid::mesh(std::size_t level) const {
  return level == 0 ? mesh_ : coarser_[level - 1]->mesh;
}

const System& Multigrid::system(std::size_t level) const {
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
    check(MatMult(coarser_[level]->prolongation.get(), wrap(coarse.col(k), comm_).get(),
                  wrap(fine.col(k), comm_).get()));
  }
  return fine;
}

Eigen::MatrixXd Multigrid::restriction(std::size_t level,
                                       const Eigen::Ref<const Eigen::MatrixXd>& fine) const {
  Eigen::MatrixXd coarse(system(level + 1).owned_unknowns(), fine.cols());
  for (Eigen::Index k = 0; k < fine.cols(); ++k) {
    check(MatMultTranspose(coarser_[level]->prolongation.get(), wrap(fine.col(k), comm_).get(),
                           wrap(coarse.col(k), comm_).get()));
  }
  return coarse;
}

}  // namespace carillon::solvers
