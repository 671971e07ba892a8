#include "solvers/krylov_schur.hpp"

#include <fmt/core.h>
#include <slepceps.h>

#include <algorithm>

#include "core/error.hpp"
#include "solvers/start_vectors.hpp"

namespace carillon::solvers {
namespace {

using EpsHandle = core::Handle<EPS, EPSDestroy>;

/// Owned values of a vector as one column.
class Column {
 public:
  explicit Column(Vec vector) : vector_(vector) {
    PetscInt rows = 0;
    check(VecGetLocalSize(vector, &rows));
    check(VecGetArray(vector, &values_));
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
  check(VecCreateMPIWithArray(comm, 3, rows, PETSC_DETERMINE, values, out.put()));
  return out;
}

}  // namespace

EigenPairs krylov_schur(const System& system, const EigenRequest& request,
                        const ShiftedSystem& shifted, MPI_Comm comm) {
  // The operator is K - sigma M itself and the target zero, so that M need never be added to
  // another matrix; sigma is added to what comes out.
  EpsHandle eps;
  check(EPSCreate(comm, eps.put()));
  check(EPSSetOperators(eps.get(), shifted.matrix.get(), shifted.mass.get()));
  check(EPSSetProblemType(eps.get(), EPS_GHEP));
  check(EPSSetType(eps.get(), EPSKRYLOVSCHUR));
  check(EPSSetTarget(eps.get(), 0));
  check(EPSSetWhichEigenpairs(eps.get(), EPS_TARGET_MAGNITUDE));
  const auto unknowns = static_cast<PetscInt>(system.unknowns());
  const PetscInt wanted = std::min<PetscInt>(request.pairs, unknowns);
  // Beyond 150 modes the projected problem is held small, which bounds the basis' memory.
  const PetscInt projected = wanted > 150 ? 150 : PETSC_DEFAULT;
  check(EPSSetDimensions(eps.get(), wanted, PETSC_DEFAULT, projected));
  check(EPSSetTolerances(eps.get(), request.tolerance, 1000));
  check(EPSSetPurify(eps.get(), PETSC_FALSE));
  ST st = nullptr;
  KSP ksp = nullptr;
  PC pc = nullptr;
  check(EPSGetST(eps.get(), &st));
  check(STSetType(st, STSINVERT));
  check(STGetKSP(st, &ksp));
  check(KSPSetType(ksp, KSPPREONLY));
  check(KSPGetPC(ksp, &pc));
  check(PCSetType(pc, PCSHELL));
  check(PCShellSetContext(pc, const_cast<Inverse*>(&shifted.inverse)));
  check(PCShellSetApply(pc, apply_inverse));
  VecHandle start;
  check(MatCreateVecs(shifted.matrix.get(), start.put(), nullptr));
  fill_start(system, request.seed, 0, Column(start.get()).get().col(0));
  Vec first = start.get();
  check(EPSSetInitialSpace(eps.get(), 1, &first));
  check(EPSSolve(eps.get()));

  PetscInt found = 0;
  check(EPSGetConverged(eps.get(), &found));
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
    check(EPSGetEigenpair(eps.get(), k, &value, nullptr, x.get(), nullptr));
    pairs.values.push_back(value + shifted.shift);
  }
  return pairs;
}

}  // namespace carillon::solvers
