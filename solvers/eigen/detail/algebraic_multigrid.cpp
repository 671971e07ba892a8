#include "solvers/eigen/detail/algebraic_multigrid.hpp"

#include <petscksp.h>

#include <Eigen/QR>
#include <memory>
#include <vector>

namespace carillon::solvers::eigen {
namespace {

using PcHandle = core::Handle<PC, PCDestroy>;
using NullSpaceHandle = core::Handle<MatNullSpace, MatNullSpaceDestroy>;

/// Rigid motions by owned unknowns. Components share the six columns: aggregates never span two,
/// so one set of motions serves all.
Eigen::MatrixXd motions_by_row(const assembly::System& system, const RigidMotions& motions) {
  Eigen::MatrixXd out(system.owned_unknowns(), 6);
  for (std::int32_t row = 0; row < system.graph.rows(); ++row) {
    const auto number = static_cast<std::size_t>(system.graph.begin + row);
    out.middleRows<3>(3 * row) =
        motions.at(static_cast<std::size_t>(system.partition.node[number]));
  }
  return out;
}

NullSpaceHandle near_null_space(Eigen::MatrixXd motions, MPI_Comm comm) {
  // PETSc wants them orthonormal.
  Eigen::MatrixXd gram = motions.transpose() * motions;
  MPI_Allreduce(MPI_IN_PLACE, gram.data(), static_cast<int>(gram.size()), MPI_DOUBLE, MPI_SUM,
                comm);
  const Eigen::LLT<Eigen::MatrixXd> factor(gram);
  motions = factor.matrixL().solve(motions.transpose()).transpose().eval();
  std::vector<VecHandle> owners;
  std::vector<Vec> vectors;
  for (Eigen::Index k = 0; k < motions.cols(); ++k) {
    VecHandle vector;
    const auto rows = static_cast<PetscInt>(motions.rows());
    libraries::check(VecCreateMPI(comm, rows, PETSC_DETERMINE, vector.put()));
    libraries::check(VecSetBlockSize(vector.get(), 3));
    double* values = nullptr;
    libraries::check(VecGetArray(vector.get(), &values));
    Eigen::Map<Eigen::VectorXd>(values, motions.rows()) = motions.col(k);
    libraries::check(VecRestoreArray(vector.get(), &values));
    vectors.push_back(vector.get());
    owners.push_back(std::move(vector));
  }
  NullSpaceHandle out;
  libraries::check(MatNullSpaceCreate(comm, PETSC_FALSE, static_cast<PetscInt>(vectors.size()),
                                      vectors.data(), out.put()));
  return out;
}

}  // namespace

Inverse algebraic_multigrid_cycle(const assembly::System& system, const RigidMotions& motions,
                                  double shift, MPI_Comm comm) {
  const auto matrix = shifted_matrix(system, shift, true, comm);
  const auto motion_space = near_null_space(motions_by_row(system, motions), comm);
  libraries::check(MatSetNearNullSpace(matrix.get(), motion_space.get()));
  libraries::ScopedOptions options;
  options.set("pc_type", "gamg");
  options.set("pc_gamg_threshold", "0.01");
  options.set("mg_levels_ksp_type", "chebyshev");
  options.set("mg_levels_ksp_max_it", "3");
  options.set("mg_levels_pc_type", "jacobi");
  PcHandle pc;
  libraries::check(PCCreate(comm, pc.put()));
  libraries::check(PCSetOptionsPrefix(pc.get(), options.prefix().c_str()));
  libraries::check(PCSetOperators(pc.get(), matrix.get(), matrix.get()));
  libraries::check(PCSetFromOptions(pc.get()));
  libraries::check(PCSetUp(pc.get()));
  const auto shared = std::make_shared<PcHandle>(std::move(pc));
  const auto rows = system.owned_unknowns();
  return [shared, rows, comm](const Eigen::Ref<const Eigen::MatrixXd>& right,
                              Eigen::Ref<Eigen::MatrixXd> solution) {
    for (Eigen::Index k = 0; k < right.cols(); ++k) {
      VecHandle from, to;
      libraries::check(
          VecCreateMPIWithArray(comm, 3, rows, PETSC_DETERMINE, right.col(k).data(), from.put()));
      libraries::check(
          VecCreateMPIWithArray(comm, 3, rows, PETSC_DETERMINE, solution.col(k).data(), to.put()));
      libraries::check(PCApply(shared->get(), from.get(), to.get()));
    }
  };
}

}  // namespace carillon::solvers::eigen
