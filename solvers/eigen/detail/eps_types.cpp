#include "solvers/eigen/detail/eps_types.hpp"

// A type of SLEPc's is made of what SLEPc's own types are made of.
#include <slepc/private/epsimpl.h>

#include <algorithm>
#include <utility>

#include "solvers/eigen/detail/block_lanczos.hpp"
#include "solvers/eigen/transformation.hpp"

namespace carillon::solvers::eigen {
namespace {

/// What an EPS of each type holds beside what every EPS holds.
struct BlockLanczos {
  BlockLanczosSpace space;
  PetscInt block = LanczosOptions().block;
  PetscInt basis = 0;  ///< vectors that are kept
};
struct Lobpcg {
  LobpcgSolve solve;
};

MPI_Comm comm_of(EPS eps) {
  return PetscObjectComm(reinterpret_cast<PetscObject>(eps));
}

const char* type_of(EPS eps) {
  return reinterpret_cast<PetscObject>(eps)->type_name;
}

template <class Data>
Data& data_of(EPS eps) {
  return *static_cast<Data*>(eps->data);
}

template <class Data>
Data* data_of(EPS eps, EPSType type) {
  PetscBool same = PETSC_FALSE;
  libraries::check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(eps), type, &same));
  return same == PETSC_TRUE ? &data_of<Data>(eps) : nullptr;
}

/// Settings that both types share, and room for the pairs.
PetscErrorCode set_up_pairs(EPS eps, PetscInt pairs) {
  PetscFunctionBegin;
  EPSCheckHermitianDefinite(eps);
  EPSCheckSinvert(eps);
  EPSCheckUnsupported(eps, EPS_FEATURE_BALANCE | EPS_FEATURE_ARBITRARY | EPS_FEATURE_REGION |
                               EPS_FEATURE_EXTRACTION | EPS_FEATURE_CONVERGENCE |
                               EPS_FEATURE_STOPPING | EPS_FEATURE_TWOSIDED);
  PetscCheck(eps->which == EPS_TARGET_MAGNITUDE, comm_of(eps), PETSC_ERR_SUP,
             "The solver '%s' finds the pairs next to a target only", type_of(eps));
  eps->ncv = std::min(pairs, eps->n);
  PetscCall(EPSAllocateSolution(eps, 0));
  PetscFunctionReturn(0);
}

PetscErrorCode sort_by_target(EPS eps) {
  eps->sc->comparison = SlepcCompareTargetMagnitude;
  eps->sc->comparisonctx = &eps->target;
  eps->sc->map = nullptr;
  eps->sc->mapobj = nullptr;
  return 0;
}

/// Hands over what was found to where SLEPc keeps it, as far as there is room.
/// @param found  how many of the values and vectors count
void hand_over(EPS eps, const Eigen::VectorXd& values, const Eigen::MatrixXd& vectors,
               Eigen::Index found, PetscInt wanted) {
  const auto kept = std::min<Eigen::Index>(eps->ncv, found);
  std::copy_n(values.data(), kept, eps->eigr);
  double* columns = nullptr;
  libraries::check(BVGetArray(eps->V, &columns));
  PetscInt stride = eps->nloc;
#if SLEPC_VERSION_GE(3, 20, 0)
  libraries::check(BVGetLeadingDimension(eps->V, &stride));
#endif
  Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>>(
      columns, eps->nloc, kept, Eigen::OuterStride<>(std::max<PetscInt>(1, stride))) =
      vectors.leftCols(kept);
  libraries::check(BVRestoreArray(eps->V, &columns));
  eps->nconv = static_cast<PetscInt>(kept);
  eps->reason = kept >= wanted ? EPS_CONVERGED_TOL : EPS_DIVERGED_ITS;
}

template <class Data>
PetscErrorCode let_go(EPS eps) {
  delete static_cast<Data*>(eps->data);
  eps->data = nullptr;
  return 0;
}

/// Pairs that block Lanczos is to find: its space may be smaller than the matrices.
PetscInt wanted_of(EPS eps) {
  return std::min(eps->nev, static_cast<PetscInt>(data_of<BlockLanczos>(eps).space.dimension));
}

PetscErrorCode set_up_lanczos(EPS eps) {
  auto& own = data_of<BlockLanczos>(eps);
  PetscFunctionBegin;
  PetscCheck(own.space.start, comm_of(eps), PETSC_ERR_ORDER, "The solver '%s' wants start vectors",
             type_of(eps));
  const auto pairs = wanted_of(eps);
  // What is not set is negative, by one constant or another from version to version.
  const auto asked = std::max<PetscInt>(0, eps->mpd > 0 ? eps->mpd : eps->ncv);
  own.basis = static_cast<PetscInt>(lanczos_basis(own.space.dimension, pairs, own.block, asked));
  eps->mpd = own.basis;
  if (eps->max_it <= 0) eps->max_it = LanczosOptions().max_restarts + 1;
  // A block brings some more than are wanted.
  PetscCall(set_up_pairs(eps, pairs + own.block));
  PetscFunctionReturn(0);
}

/// Hands on to SLEPc's monitors how far the solve is.
void tell(EPS eps, int restarts, Eigen::Index converged, const Eigen::VectorXd& values,
          const Eigen::VectorXd& residuals) {
  const auto shown = std::min<Eigen::Index>(eps->ncv, values.size());
  std::copy_n(values.data(), shown, eps->eigr);
  std::copy_n(residuals.data(), shown, eps->errest);
  eps->its = restarts + 1;
  eps->nconv = static_cast<PetscInt>(std::min(converged, shown));
  libraries::check(EPSMonitor(eps, eps->its, eps->nconv, eps->eigr, eps->eigi, eps->errest,
                              static_cast<PetscInt>(shown)));
}

int solve_lanczos(EPS eps) {
  return libraries::guarded([&] {
    auto& own = data_of<BlockLanczos>(eps);
    LanczosProblem problem;
    problem.owned = eps->nloc;
    problem.total = own.space.dimension;
    problem.comm = comm_of(eps);
    // The EPS holds its transformation as long as it solves.
    problem.apply = inverse_of(Transformation(eps->st, [](ST) {}));
    problem.mass = own.space.mass;
    problem.start = own.space.start;
    problem.monitor = [eps](int restarts, Eigen::Index converged, const Eigen::VectorXd& values,
                            const Eigen::VectorXd& residuals) {
      tell(eps, restarts, converged, values, residuals);
    };
    LanczosOptions options;
    options.pairs = eps->nev;
    options.tolerance = eps->tol;
    options.block = own.block;
    options.basis = own.basis;
    options.max_restarts = eps->max_it - 1;
    const auto found = block_lanczos(problem, options);
    eps->its = found.restarts + 1;
    hand_over(eps, found.values, found.vectors, found.values.size(), wanted_of(eps));
  });
}

PetscErrorCode transform_back(EPS eps) {
  return STBackTransform(eps->st, eps->nconv, eps->eigr, eps->eigi);
}

PetscErrorCode read_lanczos_options(EPS eps, PetscOptionItems* PetscOptionsObject) {
  auto& own = data_of<BlockLanczos>(eps);
  PetscFunctionBegin;
  PetscOptionsHeadBegin(PetscOptionsObject, "EPS block Lanczos options");
  PetscCall(PetscOptionsRangeInt("-eps_blocklanczos_block", "Columns that are solved for together",
                                 "", own.block, &own.block, nullptr, 1, 1000));
  PetscOptionsHeadEnd();
  PetscFunctionReturn(0);
}

PetscErrorCode view_lanczos(EPS eps, PetscViewer viewer) {
  const auto& own = data_of<BlockLanczos>(eps);
  PetscBool is_text = PETSC_FALSE;
  PetscFunctionBegin;
  PetscCall(
      PetscObjectTypeCompare(reinterpret_cast<PetscObject>(viewer), PETSCVIEWERASCII, &is_text));
  if (is_text == PETSC_FALSE) PetscFunctionReturn(0);
  PetscCall(PetscViewerASCIIPrintf(viewer, "  blocks of %d columns, %d vectors kept\n",
                                   static_cast<int>(own.block), static_cast<int>(own.basis)));
  PetscFunctionReturn(0);
}

PetscErrorCode make_lanczos(EPS eps) {
  eps->data = new BlockLanczos;
  eps->categ = EPS_CATEGORY_KRYLOV;
  eps->ops->setup = set_up_lanczos;
  eps->ops->setupsort = sort_by_target;
  eps->ops->solve = solve_lanczos;
  eps->ops->setfromoptions = read_lanczos_options;
  eps->ops->view = view_lanczos;
  eps->ops->backtransform = transform_back;
  eps->ops->destroy = let_go<BlockLanczos>;
  return 0;
}

PetscErrorCode set_up_lobpcg(EPS eps) {
  PetscFunctionBegin;
  PetscCheck(data_of<Lobpcg>(eps).solve, comm_of(eps), PETSC_ERR_ORDER,
             "The solver '%s' wants a preconditioner", type_of(eps));
  if (eps->max_it <= 0) eps->max_it = LobpcgOptions().max_iterations;
  PetscCall(set_up_pairs(eps, eps->nev));
  PetscFunctionReturn(0);
}

int solve_lobpcg(EPS eps) {
  return libraries::guarded([&] {
    const auto found = data_of<Lobpcg>(eps).solve(eps->tol, eps->max_it);
    eps->its = found.iterations;
    hand_over(eps, found.values, found.vectors, found.converged, eps->nev);
  });
}

PetscErrorCode make_lobpcg(EPS eps) {
  eps->data = new Lobpcg;
  eps->categ = EPS_CATEGORY_OTHER;
  eps->ops->setup = set_up_lobpcg;
  eps->ops->setupsort = sort_by_target;
  eps->ops->solve = solve_lobpcg;
  // It works on lambda itself.
  eps->ops->backtransform = [](EPS) -> PetscErrorCode { return 0; };
  eps->ops->destroy = let_go<Lobpcg>;
  return 0;
}

}  // namespace

void destroy_eps(EPS* eps) {
  ST none = nullptr;
  STCreate(PetscObjectComm(reinterpret_cast<PetscObject>(*eps)), &none);
  EPSSetST(*eps, none);
  STDestroy(&none);
  EPSDestroy(eps);
}

void register_eps_types() {
  libraries::check(EPSRegister(block_lanczos_type, make_lanczos));
  libraries::check(EPSRegister(lobpcg_type, make_lobpcg));
}

void set_space(EPS eps, BlockLanczosSpace space) {
  if (auto* const own = data_of<BlockLanczos>(eps, block_lanczos_type)) {
    own->space = std::move(space);
  }
}

void set_solve(EPS eps, LobpcgSolve solve) {
  if (auto* const own = data_of<Lobpcg>(eps, lobpcg_type)) own->solve = std::move(solve);
}

}  // namespace carillon::solvers::eigen
