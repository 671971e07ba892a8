#include "solvers/multigrid.hpp"

#include <memory>
#include <optional>
#include <vector>

#include "solvers/algebraic_multigrid.hpp"
#include "solvers/p_coarsening.hpp"
#include "solvers/rigid.hpp"
#include "solvers/smoother.hpp"

namespace carillon::solvers {
namespace {

/// Degree of the smoothing polynomial: one more costs two products by cycle.
constexpr int smoothing_degree = 4;

/// P x and P^T x, column by column.
void prolong(Mat prolongation, const Eigen::MatrixXd& coarse, Eigen::MatrixXd& fine,
             MPI_Comm comm) {
  for (Eigen::Index k = 0; k < coarse.cols(); ++k) {
    VecHandle from, to;
    check(VecCreateMPIWithArray(comm, 3, static_cast<PetscInt>(coarse.rows()), PETSC_DETERMINE,
                                coarse.col(k).data(), from.put()));
    check(VecCreateMPIWithArray(comm, 3, static_cast<PetscInt>(fine.rows()), PETSC_DETERMINE,
                                fine.col(k).data(), to.put()));
    check(MatMult(prolongation, from.get(), to.get()));
  }
}

void restrict(Mat prolongation, const Eigen::MatrixXd& fine, Eigen::MatrixXd& coarse,
              MPI_Comm comm) {
  for (Eigen::Index k = 0; k < fine.cols(); ++k) {
    VecHandle from, to;
    check(VecCreateMPIWithArray(comm, 3, static_cast<PetscInt>(fine.rows()), PETSC_DETERMINE,
                                fine.col(k).data(), from.put()));
    check(VecCreateMPIWithArray(comm, 3, static_cast<PetscInt>(coarse.rows()), PETSC_DETERMINE,
                                coarse.col(k).data(), to.put()));
    check(MatMultTranspose(prolongation, from.get(), to.get()));
  }
}

/// A level's equations factored, if that takes no more memory than is given.
std::optional<Inverse> factor_within(const System& system, double shift, std::int64_t bytes,
                                     MPI_Comm comm) {
  const auto plan = plan_factors(system, comm);
  if (predict_factor(system, FactorPurpose::solve, plan, comm).bytes > bytes) return std::nullopt;
  return factored_inverse(system, shift, plan, comm);
}

/// The levels of one body, from its own order downward.
class Cycle {
 public:
  Cycle(const TetMesh& mesh, std::span<const Elastic> regions, const System& system,
        const std::vector<std::int32_t>& component, double shift, std::int64_t factor_bytes,
        MPI_Comm comm)
      : comm_(comm) {
    const TetMesh* finest = &mesh;
    const System* last = &system;
    while (finest->order > 1) {
      smoothers_.push_back(std::make_unique<Smoother>(*last, shift, smoothing_degree, comm));
      const int order = finest->order > 2 ? 2 : 1;
      levels_.push_back(
          std::make_unique<PLevel>(coarsen(mesh, regions, *finest, last->partition, order, comm)));
      finest = &levels_.back()->mesh;
      last = &levels_.back()->system;
      if (const auto direct = factor_within(*last, shift, factor_bytes, comm)) {
        coarsest_ = *direct;
        return;
      }
    }
    const auto parts = levels_.empty() ? component : node_components(*finest);
    const RigidMotions motions(*finest, last->scales, parts);
    coarsest_ = algebraic_multigrid_cycle(*last, motions, shift, comm);
  }

  void apply(std::size_t level, const Eigen::Ref<const Eigen::MatrixXd>& right,
             Eigen::Ref<Eigen::MatrixXd> solution) const {
    if (level == smoothers_.size()) {
      coarsest_(right, solution);
      return;
    }
    const auto& smoother = *smoothers_[level];
    const auto& coarse = *levels_[level];
    const auto columns = right.cols();
    smoother.smooth(right, solution);
    Eigen::MatrixXd residual(right.rows(), columns), correction(right.rows(), columns);
    smoother.multiply(solution, residual);
    residual = right - residual;
    Eigen::MatrixXd coarse_right(coarse.system.owned_unknowns(), columns);
    Eigen::MatrixXd coarse_solution(coarse.system.owned_unknowns(), columns);
    restrict(coarse.prolongation.get(), residual, coarse_right, comm_);
    apply(level + 1, coarse_right, coarse_solution);
    prolong(coarse.prolongation.get(), coarse_solution, correction, comm_);
    solution += correction;
    smoother.multiply(solution, residual);
    residual = right - residual;
    smoother.smooth(residual, correction);
    solution += correction;
  }

 private:
  std::vector<std::unique_ptr<Smoother>> smoothers_;
  std::vector<std::unique_ptr<PLevel>> levels_;
  Inverse coarsest_;
  MPI_Comm comm_;
};

}  // namespace

Inverse multigrid_cycle(const TetMesh& mesh, std::span<const Elastic> regions, const System& system,
                        const std::vector<std::int32_t>& component, double shift,
                        std::int64_t factor_bytes, MPI_Comm comm) {
  const auto cycle =
      std::make_shared<const Cycle>(mesh, regions, system, component, shift, factor_bytes, comm);
  return [cycle](const Eigen::Ref<const Eigen::MatrixXd>& right,
                 Eigen::Ref<Eigen::MatrixXd> solution) { cycle->apply(0, right, solution); };
}

}  // namespace carillon::solvers
