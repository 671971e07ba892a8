#include "solvers/eigen/detail/krylov_schur.hpp"

#include <fmt/core.h>
#include <slepceps.h>

#include <algorithm>

#include "core/error.hpp"
#include "solvers/eigen/detail/start_vectors.hpp"

namespace carillon::solvers::eigen {
namespace {

using EpsHandle = core::Handle<EPS, EPSDestroy>;

/// Owned values of a vector as one column.
class Column {
 public:
  explicit Column(Vec vector) : vector_(vector) {
    PetscInt rows = 0;
    libraries::check(VecGetLocalSize(vector, &rows));
    libraries::check(VecGetArray(vector, &values_));
    rows_ = rows;
  }
  ~Column() { VecRestoreArray(vector_, &values_); }
  Column(const Column&) = delete;
  Column& operator=(const Column&) = delete;
  Eigen::Map<Eigen::MatrixXd> get() { return {values_, rows_, 1}; }

 private:
  Vec vector_;
  double* values_ = nullptr;
  Eigen::Index rows_ = 0;
};

PetscErrorCode apply_inverse(PC shell, Vec right, Vec solution) {
  void* inverse = nullptr;
  PetscFunctionBegin;
  PetscCall(PCShellGetContext(shell, &inverse));
  // An exception must not cross PETSc's frames.
  try {
    (*static_cast<const Inverse*>(inverse))(Column(right).get(), Column(solution).get());
  } catch (const std::exception& e) {
    SETERRQ(PETSC_COMM_SELF, PETSC_ERR_LIB, "%s", e.what());
  }
  PetscFunctionReturn(0);
}

/// A vector whose values lie in a column of a matrix.
VecHandle wrap(MPI_Comm comm, double* values, PetscInt rows) {
  VecHandle out;
  libraries::check(VecCreateMPIWithArray(comm, 3, rows, PETSC_DETERMINE, values, out.put()));
  return out;
}

}  // namespace

EigenPairs krylov_schur(const assembly::System& system, const EigenRequest& request,
                        const ShiftedSystem& shifted, MPI_Comm comm) {
  // The operator is K - sigma M itself and the target zero, so that M need never be added to
  // another matrix; sigma is added to what comes out.
  EpsHandle eps;
  libraries::check(EPSCreate(comm, eps.put()));
  libraries::check(EPSSetOperators(eps.get(), shifted.matrix.get(), shifted.mass.get()));
  libraries::check(EPSSetProblemType(eps.get(), EPS_GHEP));
  libraries::check(EPSSetType(eps.get(), EPSKRYLOVSCHUR));
  libraries::check(EPSSetTarget(eps.get(), 0));
  libraries::check(EPSSetWhichEigenpairs(eps.get(), EPS_TARGET_MAGNITUDE));
  const auto unknowns = static_cast<PetscInt>(system.free_unknowns());
  const PetscInt wanted = std::min<PetscInt>(request.pairs, unknowns);
  // Beyond 150 modes the projected problem is held small, which bounds the basis' memory.
  const PetscInt projected = wanted > 150 ? 150 : PETSC_DEFAULT;
  libraries::check(EPSSetDimensions(eps.get(), wanted, PETSC_DEFAULT, projected));
  libraries::check(EPSSetTolerances(eps.get(), request.tolerance, 1000));
  libraries::check(EPSSetPurify(eps.get(), PETSC_FALSE));
  ST st = nullptr;
  KSP ksp = nullptr;
  PC pc = nullptr;
  libraries::check(EPSGetST(eps.get(), &st));
  libraries::check(STSetType(st, STSINVERT));
  libraries::check(STGetKSP(st, &ksp));
  libraries::check(KSPSetType(ksp, KSPPREONLY));
  libraries::check(KSPGetPC(ksp, &pc));
  libraries::check(PCSetType(pc, PCSHELL));
  libraries::check(PCShellSetContext(pc, const_cast<Inverse*>(&shifted.inverse)));
  libraries::check(PCShellSetApply(pc, apply_inverse));
  VecHandle start;
  libraries::check(MatCreateVecs(shifted.matrix.get(), start.put(), nullptr));
  fill_start(system, request.seed, 0, Column(start.get()).get().col(0));
  Vec first = start.get();
  libraries::check(EPSSetInitialSpace(eps.get(), 1, &first));
  libraries::check(EPSSolve(eps.get()));

  PetscInt found = 0;
  libraries::check(EPSGetConverged(eps.get(), &found));
  if (found < wanted) {
    throw core::SolverError(
        fmt::format("only {} of {} modes converged", found, wanted),
        "the mesh may have nearly flat elements; another element size often helps");
  }
  const auto rows = system.owned_unknowns();
  EigenPairs pairs;
  pairs.vectors.resize(rows, found);
  for (PetscInt k = 0; k < found; ++k) {
    double value = 0;
    const auto x = wrap(comm, pairs.vectors.col(k).data(), rows);
    libraries::check(EPSGetEigenpair(eps.get(), k, &value, nullptr, x.get(), nullptr));
    pairs.values.push_back(value + shifted.shift);
  }
  return pairs;
}

}  // namespace carillon::solvers::eigen
