#include "solvers/eigen_solve.hpp"

#include <fmt/core.h>
#include <slepceps.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.hpp"
#include "solvers/factor.hpp"
#include "solvers/mumps.hpp"

namespace carillon::solvers {
namespace {

using EpsHandle = core::Handle<EPS, EPSDestroy>;

int size_of(MPI_Comm comm) {
  int size = 1;
  MPI_Comm_size(comm, &size);
  return size;
}

double uniform_of(std::uint64_t x) {
  // SplitMix64's finaliser (Steele, Lea and Flood 2014).
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return static_cast<double>((x ^ (x >> 31)) >> 11) * 0x1p-52 - 1;
}

/// Start vector by mesh node, so that it is the same however the nodes are spread over ranks.
void fill_start(const System& system, std::uint64_t seed, Vec start) {
  double* values = nullptr;
  check(VecGetArray(start, &values));
  for (std::int32_t row = 0; row < system.graph.rows(); ++row) {
    const auto number = static_cast<std::size_t>(system.graph.begin + row);
    const auto node = static_cast<std::uint64_t>(system.partition.node[number]);
    for (std::uint64_t c = 0; c < 3; ++c) {
      *(values + 3 * row + static_cast<std::ptrdiff_t>(c)) =
          uniform_of((seed << 40) + 3 * node + c);
    }
  }
  check(VecRestoreArray(start, &values));
}

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

/// Residuals above this are judged in the energy norm too.
constexpr double target_residual = 1e-8;

/// Fills energy_residuals.
void measure_in_energy(const ShiftedSystem& shifted, MPI_Comm comm, EigenPairs& pairs) {
  const auto rows = pairs.vectors.rows();
  Eigen::VectorXd residual(rows), solved(rows);
  pairs.energy_residuals.assign(pairs.residuals.size(), 0.0);
  for (std::size_t k = 0; k < pairs.residuals.size(); ++k) {
    const double distance = pairs.values[k] - shifted.shift;
    // Rigid motions have no relative residual.
    if (pairs.residuals[k] <= target_residual || pairs.values[k] < -1e-6 * shifted.shift) continue;
    const auto column = static_cast<Eigen::Index>(k);
    const auto x = wrap(comm, pairs.vectors.col(column).data(), static_cast<PetscInt>(rows));
    const auto r = wrap(comm, residual.data(), static_cast<PetscInt>(rows));
    check(MatMult(shifted.matrix.get(), x.get(), r.get()));
    residual -= distance * pairs.mass_vectors.col(column);
    shifted.inverse(residual, solved);
    double square = residual.dot(solved);
    MPI_Allreduce(MPI_IN_PLACE, &square, 1, MPI_DOUBLE, MPI_SUM, comm);
    pairs.energy_residuals[k] = std::sqrt(std::max(0.0, square) / distance);
  }
}

/// Fills residuals, mass_vectors and orthonormality from values and vectors.
void measure_residuals(const System& system, const ShiftedSystem& shifted, MPI_Comm comm,
                       EigenPairs& pairs) {
  const auto rows = system.owned_unknowns();
  pairs.mass_vectors.resize(rows, pairs.size());
  Eigen::VectorXd product(rows);
  Eigen::ArrayXd squares(2 * pairs.size());
  for (Eigen::Index k = 0; k < pairs.size(); ++k) {
    const auto x = wrap(comm, pairs.vectors.col(k).data(), rows);
    const auto mx = wrap(comm, pairs.mass_vectors.col(k).data(), rows);
    const auto ax = wrap(comm, product.data(), rows);
    check(MatMult(shifted.mass.get(), x.get(), mx.get()));
    check(MatMult(shifted.matrix.get(), x.get(), ax.get()));
    const double value = pairs.values[static_cast<std::size_t>(k)];
    squares[2 * k] = (product - (value - shifted.shift) * pairs.mass_vectors.col(k)).squaredNorm();
    squares[2 * k + 1] = pairs.mass_vectors.col(k).squaredNorm();
  }
  Eigen::MatrixXd gram = pairs.vectors.transpose() * pairs.mass_vectors;
  MPI_Allreduce(MPI_IN_PLACE, squares.data(), static_cast<int>(squares.size()), MPI_DOUBLE, MPI_SUM,
                comm);
  MPI_Allreduce(MPI_IN_PLACE, gram.data(), static_cast<int>(gram.size()), MPI_DOUBLE, MPI_SUM,
                comm);
  pairs.residuals.clear();
  for (Eigen::Index k = 0; k < pairs.size(); ++k) {
    const double value = std::abs(pairs.values[static_cast<std::size_t>(k)]);
    pairs.residuals.push_back(std::sqrt(squares[2 * k] / squares[2 * k + 1]) / value);
  }
  gram.diagonal().array() -= 1;
  pairs.orthonormality = gram.size() == 0 ? 0 : gram.cwiseAbs().maxCoeff();
}

void krylov_schur(const System& system, const EigenRequest& request, const ShiftedSystem& shifted,
                  MPI_Comm comm, EigenPairs& pairs) {
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
  fill_start(system, request.seed, start.get());
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
  pairs.vectors.resize(rows, found);
  for (PetscInt k = 0; k < found; ++k) {
    double value = 0;
    const auto x = wrap(comm, pairs.vectors.col(k).data(), rows);
    check(EPSGetEigenpair(eps.get(), k, &value, nullptr, x.get(), nullptr));
    pairs.values.push_back(value + shifted.shift);
  }
}

/// All eigenpairs of a small problem on one rank, by Eigen.
void dense(const System& system, const EigenRequest& request, double shift, EigenPairs& pairs) {
  const auto n = static_cast<Eigen::Index>(system.unknowns());
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n), m = a;
  const auto& graph = system.graph;
  for (Eigen::Index row = 0; row < graph.rows(); ++row) {
    const auto begin = graph.first[static_cast<std::size_t>(row)];
    const auto width = graph.first[static_cast<std::size_t>(row) + 1] - begin;
    for (Eigen::Index k = 0; k < width; ++k) {
      const Eigen::Index column = graph.column[static_cast<std::size_t>(begin + k)];
      for (Eigen::Index i = 0; i < 3; ++i) {
        for (Eigen::Index j = 0; j < 3; ++j) {
          const auto at = 9 * begin + i * 3 * width + 3 * k + j;
          a(3 * row + i, 3 * column + j) = system.stiffness[static_cast<std::size_t>(at)];
        }
        m(3 * row + i, 3 * column + i) = system.mass[static_cast<std::size_t>(begin + k)];
      }
    }
  }
  a -= shift * m;
  // Roles exchanged: the largest eigenvalues of M x = nu (K - sigma M) x are the wanted ones, and
  // come out with the better accuracy.
  Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(m, a);
  if (solver.info() != Eigen::Success) {
    throw core::SolverError("the dense eigenproblem could not be solved",
                            "the mesh may have elements that are nearly flat");
  }
  const auto wanted = std::min<Eigen::Index>(request.pairs, n);
  pairs.vectors.resize(n, wanted);
  for (Eigen::Index k = 0; k < wanted; ++k) {
    const double inverse = solver.eigenvalues()[n - 1 - k];
    pairs.values.push_back(1 / inverse + shift);
    pairs.vectors.col(k) = solver.eigenvectors().col(n - 1 - k) / std::sqrt(inverse);
  }
}

/// Krylov methods want a space much larger than what is asked for.
bool wants_dense(std::int64_t unknowns, int pairs) {
  return unknowns <= 400 || (unknowns <= 2000 && 3 * static_cast<std::int64_t>(pairs) > unknowns);
}

}  // namespace

std::int64_t count_below(const System& system, double value, const FactorPlan& plan,
                         MPI_Comm comm) {
  for (int tries = 0; tries < 4; ++tries) {
    Mumps factor(system, Mumps::Purpose::inertia, plan.node_order, comm);
    factor.factor(value);
    const auto inertia = factor.inertia();
    if (inertia.zero == 0) return inertia.negative;
    value *= 1 + 1e-6;
  }
  throw core::SolverError(fmt::format("an eigenvalue lies at every frequency tried near {:.6g} Hz",
                                      system.scales.to_frequency(value)),
                          "the matrices may be singular: check for parts of no mass or stiffness");
}

ShiftedSystem factor_shifted(const System& system, double shift, const FactorPlan& plan,
                             MPI_Comm comm) {
  ShiftedSystem shifted;
  shifted.shift = shift;
  shifted.matrix = shifted_product(system, shift, comm);
  shifted.mass = mass_matrix(system, comm);
  shifted.inverse = factored_inverse(system, shift, plan, comm);
  shifted.preconditioner = shifted.inverse;
  return shifted;
}

EigenPairs lowest_pairs(const System& system, const EigenRequest& request,
                        const ShiftedSystem& shifted, MPI_Comm comm) {
  EigenPairs pairs;
  if (size_of(comm) == 1 && wants_dense(system.unknowns(), request.pairs)) {
    dense(system, request, shifted.shift, pairs);
  } else {
    krylov_schur(system, request, shifted, comm, pairs);
  }
  measure(system, shifted, comm, pairs);
  return pairs;
}

void measure(const System& system, const ShiftedSystem& shifted, MPI_Comm comm, EigenPairs& pairs) {
  measure_residuals(system, shifted, comm, pairs);
  measure_in_energy(shifted, comm, pairs);
}

}  // namespace carillon::solvers
