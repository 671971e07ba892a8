#include "solvers/eigen/transformation.hpp"

#include <petsc/private/petscimpl.h>  // PetscObjectStateIncrease

#include <array>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "core/error.hpp"
#include "solvers/assembly/products.hpp"

namespace carillon::solvers::eigen {
namespace {

using Columns = Eigen::Ref<Eigen::MatrixXd>;
using ConstColumns = Eigen::Ref<const Eigen::MatrixXd>;

/// PETSc's name for the factors made here.
constexpr const char* package = "carillon";

/// K - shift M, or M alone, of a System.
struct SystemMatrix {
  const assembly::System* system;
  std::shared_ptr<const assembly::Products> products;
  bool is_mass = false;
  double shift = 0;
  std::shared_ptr<const FactorPlan> plan = {};  ///< null where no factor is made
  std::function<void()> before_solve = {};      ///< of a factor

  // Written through: NOLINTNEXTLINE(performance-unnecessary-value-param)
  void multiply(const ConstColumns& x, Columns out) const {
    if (is_mass) {
      products->mass(x, out);
    } else {
      products->shifted(shift, x, out);
    }
  }
};

template <class Context>
Context* context_of(Mat matrix) {
  Context* context = nullptr;
  libraries::check(MatShellGetContext(matrix, &context));
  return context;
}

/// Calls apply(right, solution) on this rank's values.
template <class Apply>
PetscErrorCode on_values(Vec right, Vec solution, const Apply& apply) {
  PetscInt rows = 0;
  const double* from = nullptr;
  double* to = nullptr;
  PetscFunctionBegin;
  PetscCall(VecGetLocalSize(right, &rows));
  PetscCall(VecGetArrayRead(right, &from));
  PetscCall(VecGetArrayWrite(solution, &to));
  const int failed = libraries::guarded([&] {
    const Eigen::Map<const Eigen::MatrixXd> in(from, rows, 1);
    Eigen::Map<Eigen::MatrixXd> out(to, rows, 1);
    apply(in, out);
  });
  PetscCall(VecRestoreArrayWrite(solution, &to));
  PetscCall(VecRestoreArrayRead(right, &from));
  PetscFunctionReturn(failed);
}

/// The same on the columns of dense matrices.
template <class Apply>
PetscErrorCode on_values(Mat right, Mat solution, const Apply& apply) {
  using Stride = Eigen::OuterStride<>;
  PetscInt rows = 0, columns = 0, from_stride = 0, to_stride = 0;
  const double* from = nullptr;
  double* to = nullptr;
  PetscFunctionBegin;
  PetscCall(MatGetLocalSize(right, &rows, nullptr));
  PetscCall(MatGetSize(right, nullptr, &columns));
  PetscCall(MatDenseGetLDA(right, &from_stride));
  PetscCall(MatDenseGetLDA(solution, &to_stride));
  PetscCall(MatDenseGetArrayRead(right, &from));
  PetscCall(MatDenseGetArrayWrite(solution, &to));
  const int failed = libraries::guarded([&] {
    const Eigen::Map<const Eigen::MatrixXd, 0, Stride> in(from, rows, columns, Stride(from_stride));
    Eigen::Map<Eigen::MatrixXd, 0, Stride> out(to, rows, columns, Stride(to_stride));
    apply(in, out);
  });
  PetscCall(MatDenseRestoreArrayWrite(solution, &to));
  PetscCall(MatDenseRestoreArrayRead(right, &from));
  PetscFunctionReturn(failed);
}

template <class Function>
void set_operation(Mat matrix, MatOperation operation, Function* function) {
  libraries::check(MatShellSetOperation(matrix, operation, reinterpret_cast<void (*)()>(function)));
}

/// A shell matrix of this rank's rows that owns its context.
template <class Context>
MatHandle make_shell(MPI_Comm comm, PetscInt rows, std::unique_ptr<Context> context) {
  MatHandle matrix;
  libraries::check(MatCreateShell(comm, rows, rows, PETSC_DETERMINE, PETSC_DETERMINE, context.get(),
                                  matrix.put()));
  static_cast<void>(context.release());  // the matrix has it
  set_operation(
      matrix.get(), MATOP_DESTROY,
      +[](Mat shell) { return libraries::guarded([&] { delete context_of<Context>(shell); }); });
  return matrix;
}

int multiply(Mat matrix, Vec x, Vec out) {
  return on_values(x, out, [&](const auto& in, auto& product) {
    context_of<SystemMatrix>(matrix)->multiply(in, product);
  });
}

int duplicate(Mat matrix, MatDuplicateOption option, Mat* out);

/// Adds a multiple of M to K - shift M.
int add_multiple(Mat matrix, PetscScalar factor, Mat other, MatStructure) {
  return libraries::guarded([&] {
    if (!context_of<SystemMatrix>(other)->is_mass) {
      throw std::logic_error("only M is added to K - shift M");
    }
    context_of<SystemMatrix>(matrix)->shift -= factor;
    libraries::check(PetscObjectStateIncrease(reinterpret_cast<PetscObject>(matrix)));
  });
}

MatHandle make_matrix(SystemMatrix matrix, MPI_Comm comm) {
  const PetscInt rows = matrix.system->owned_unknowns();
  auto out = make_shell(comm, rows, std::make_unique<SystemMatrix>(std::move(matrix)));
  libraries::check(MatShellSetManageScalingShifts(out.get()));
  set_operation(out.get(), MATOP_MULT, multiply);
  set_operation(out.get(), MATOP_DUPLICATE, duplicate);
  set_operation(out.get(), MATOP_AXPY, add_multiple);
  libraries::check(MatSetOption(out.get(), MAT_SYMMETRIC, PETSC_TRUE));
  libraries::check(MatSetOption(out.get(), MAT_SYMMETRY_ETERNAL, PETSC_TRUE));
  return out;
}

int duplicate(Mat matrix, MatDuplicateOption, Mat* out) {
  return libraries::guarded([&] {
    auto copy = make_matrix(*context_of<SystemMatrix>(matrix),
                            PetscObjectComm(reinterpret_cast<PetscObject>(matrix)));
    *out = copy.release();
  });
}

/// A factor of a SystemMatrix, to be filled in.
struct Factor {
  Inverse inverse;
  std::function<void()> before_solve;
  double entries = 0;
};

template <class Values>
int solve(Mat factor, Values right, Values solution) {
  return on_values(right, solution, [&](const auto& from, auto& to) {
    const auto& own = *context_of<Factor>(factor);
    if (own.before_solve) own.before_solve();
    own.inverse(from, to);
  });
}

int factorise(Mat factor, Mat matrix, const MatFactorInfo*) {
  return libraries::guarded([&] {
    const auto& of = *context_of<SystemMatrix>(matrix);
    const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(matrix));
    auto& own = *context_of<Factor>(factor);
    own.before_solve = of.before_solve;
    own.inverse = factored_inverse(*of.system, of.shift, *of.plan, comm);
    if (const auto& structure = of.plan->structure) {
      own.entries = static_cast<double>(structure->size().entries);
    }
  });
}

int plan_is_there(Mat, Mat, IS, const MatFactorInfo*) {
  return 0;
}

/// What is known of a factor's entries; MUMPS' are not.
int tell_entries(Mat factor, MatInfoType, MatInfo* info) {
  return libraries::guarded([&] {
    *info = MatInfo{};
    info->nz_used = info->nz_allocated = context_of<Factor>(factor)->entries;
  });
}

int package_of(Mat, MatSolverType* type) {
  *type = package;
  return 0;
}

int make_factor(Mat matrix, MatFactorType type, Mat* out) {
  return libraries::guarded([&] {
    PetscInt rows = 0;
    libraries::check(MatGetLocalSize(matrix, &rows, nullptr));
    auto factor = make_shell(PetscObjectComm(reinterpret_cast<PetscObject>(matrix)), rows,
                             std::make_unique<Factor>());
    set_operation(factor.get(), MATOP_CHOLESKY_FACTOR_SYMBOLIC, plan_is_there);
    set_operation(factor.get(), MATOP_CHOLESKY_FACTOR_NUMERIC, factorise);
    set_operation(factor.get(), MATOP_SOLVE, solve<Vec>);
    set_operation(factor.get(), MATOP_MAT_SOLVE, solve<Mat>);
    set_operation(factor.get(), MATOP_GETINFO, tell_entries);
    libraries::check(PetscObjectComposeFunction(reinterpret_cast<PetscObject>(factor.get()),
                                                "MatFactorGetSolverType_C", package_of));
    libraries::check(MatSetFactorType(factor.get(), type));
    *out = factor.release();
  });
}

/// Makes the package known to PETSc, once.
void register_package() {
  static bool is_registered = false;
  if (std::exchange(is_registered, true)) return;
  libraries::check(MatInitializePackage());  // or PETSc would leave out its own
  libraries::check(MatSolverTypeRegister(package, MATSHELL, MAT_FACTOR_CHOLESKY, make_factor));
}

template <class Values>
int apply_given(PC preconditioner, Values right, Values solution) {
  Inverse* inverse = nullptr;
  PetscFunctionBegin;
  PetscCall(PCShellGetContext(preconditioner, &inverse));
  PetscFunctionReturn(on_values(right, solution, *inverse));
}

int let_go(PC preconditioner) {
  return libraries::guarded([&] {
    Inverse* inverse = nullptr;
    libraries::check(PCShellGetContext(preconditioner, &inverse));
    delete inverse;
  });
}

KSP solver_of(ST st) {
  KSP ksp = nullptr;
  libraries::check(STGetKSP(st, &ksp));
  return ksp;
}

PC preconditioner_of(ST st) {
  PC pc = nullptr;
  libraries::check(KSPGetPC(solver_of(st), &pc));
  return pc;
}

/// Shift-invert with one application of the preconditioner, still without matrices.
Transformation begin(double shift, MPI_Comm comm) {
  ST raw = nullptr;
  libraries::check(STCreate(comm, &raw));
  Transformation st(raw, [](ST made) { STDestroy(&made); });
  libraries::check(STSetType(raw, STSINVERT));
  libraries::check(STSetShift(raw, shift));
  // As an EPS with this target sets it, which would otherwise undo what is set up.
  libraries::check(STSetDefaultShift(raw, shift));
  libraries::check(STSetTransform(raw, PETSC_TRUE));
  libraries::check(KSPSetType(solver_of(raw), KSPPREONLY));
  return st;
}

/// Whether options left the preconditioner as it was set.
bool is_own(ST st, PCType type) {
  PetscBool same = PETSC_FALSE;
  auto* const pc = reinterpret_cast<PetscObject>(preconditioner_of(st));
  libraries::check(PetscObjectTypeCompare(pc, type, &same));
  if (same == PETSC_FALSE || std::string_view(type) != PCCHOLESKY) return same == PETSC_TRUE;
  MatSolverType solver = nullptr;
  libraries::check(PCFactorGetMatSolverType(preconditioner_of(st), &solver));
  return solver != nullptr && std::string_view(solver) == package;
}

/// What is done with modes relies on (K - sigma M)^-1 of the shift that was chosen.
void refuse_other_transformation(ST st, double shift) {
  PetscBool is_inverse = PETSC_FALSE;
  auto* const object = reinterpret_cast<PetscObject>(st);
  libraries::check(PetscObjectTypeCompare(object, STSINVERT, &is_inverse));
  STMatMode mode = ST_MATMODE_COPY;
  libraries::check(STGetMatMode(st, &mode));
  double found = 0;
  libraries::check(STGetShift(st, &found));
  if (is_inverse == PETSC_TRUE && mode == ST_MATMODE_COPY && found == shift) return;
  throw core::InputError(
      "PETSC_OPTIONS asks for another spectral transformation than shift-invert about the shift "
      "that is chosen here",
      "leave out -st_type, -st_shift and -st_matmode");
}

/// Reads the options, gives the transformation its matrices and makes it ready.
///
/// @param matrix  K, with the transformation's shift
void finish(ST st, PCType type, SystemMatrix matrix, MPI_Comm comm) {
  libraries::check(STSetFromOptions(st));
  refuse_other_transformation(st, matrix.shift);
  matrix.shift = 0;
  MatHandle stiffness, mass;
  if (is_own(st, type)) {
    mass = make_matrix({matrix.system, matrix.products, true}, comm);
    stiffness = make_matrix(std::move(matrix), comm);
  } else {
    stiffness = shifted_matrix(*matrix.system, 0, false, comm);
    mass = mass_matrix(*matrix.system, comm);
    libraries::check(STSetMatStructure(st, SAME_NONZERO_PATTERN));
  }
  std::array<Mat, 2> both = {stiffness.get(), mass.get()};
  libraries::check(STSetMatrices(st, 2, both.data()));
  libraries::check(STSetUp(st));
}

/// Columns as a dense matrix of PETSc's, which refers to them and has no constant values.
MatHandle dense_of(MPI_Comm comm, const ConstColumns& columns) {
  MatHandle out;
  const auto rows = static_cast<PetscInt>(columns.rows());
  const auto stride = static_cast<PetscInt>(columns.outerStride());
  libraries::check(MatCreateDense(comm, rows, PETSC_DECIDE, PETSC_DETERMINE,
                                  static_cast<PetscInt>(columns.cols()),
                                  const_cast<double*>(columns.data()), out.put()));
  if (stride > rows) libraries::check(MatDenseSetLDA(out.get(), stride));
  return out;
}

}  // namespace

Transformation factored_transformation(const assembly::System& system, double shift,
                                       const FactorPlan& plan, MPI_Comm comm,
                                       std::function<void()> before_solve) {
  register_package();
  auto st = begin(shift, comm);
  auto* const pc = preconditioner_of(st.get());
  libraries::check(PCSetType(pc, PCCHOLESKY));
  libraries::check(PCFactorSetMatSolverType(pc, package));
  SystemMatrix stiffness = {&system, std::make_shared<const assembly::Products>(system, comm)};
  stiffness.shift = shift;
  stiffness.plan = std::make_shared<const FactorPlan>(plan);
  stiffness.before_solve = std::move(before_solve);
  finish(st.get(), PCCHOLESKY, std::move(stiffness), comm);
  return st;
}

Transformation given_transformation(const assembly::System& system, double shift, Inverse inverse,
                                    MPI_Comm comm) {
  auto st = begin(shift, comm);
  auto* const pc = preconditioner_of(st.get());
  libraries::check(PCSetType(pc, PCSHELL));
  libraries::check(PCShellSetContext(pc, new Inverse(std::move(inverse))));
  libraries::check(PCShellSetDestroy(pc, let_go));
  libraries::check(PCShellSetApply(pc, apply_given<Vec>));
  libraries::check(PCShellSetMatApply(pc, apply_given<Mat>));
  libraries::check(PCShellSetName(pc, "conjugate gradients with a multigrid cycle"));
  finish(st.get(), PCSHELL,
         {&system, std::make_shared<const assembly::Products>(system, comm), false, shift}, comm);
  return st;
}

Inverse inverse_of(const Transformation& transformation) {
  // Written through: NOLINTNEXTLINE(performance-unnecessary-value-param)
  return [transformation](const ConstColumns& right, Columns solution) {
    auto* const st = transformation.get();
    const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(st));
    const auto from = dense_of(comm, right), to = dense_of(comm, solution);
    libraries::check(KSPMatSolve(solver_of(st), from.get(), to.get()));
  };
}

}  // namespace carillon::solvers::eigen
