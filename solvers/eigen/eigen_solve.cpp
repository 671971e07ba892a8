#include "solvers/eigen/eigen_solve.hpp"

#include <fmt/core.h>
#include <slepceps.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "core/error.hpp"
#include "solvers/assembly/products.hpp"
#include "solvers/eigen/detail/eps_types.hpp"
#include "solvers/eigen/detail/lobpcg.hpp"
#include "solvers/eigen/detail/mumps.hpp"
#include "solvers/eigen/detail/reduced.hpp"
#include "solvers/eigen/detail/start_vectors.hpp"

namespace carillon::solvers::eigen {
namespace {

int size_of(MPI_Comm comm) {
  int size = 1;
  MPI_Comm_size(comm, &size);
  return size;
}

/// Vectors on their way through a solver.
constexpr Eigen::Index at_a_time = 8;

/// Rigid motions have no relative residual.
bool is_rigid(double value, const ShiftedSystem& shifted) {
  return value < -1e-6 * shifted.shift;
}

/// Fills energy_residuals.
void measure_in_energy(const ShiftedSystem& shifted, MPI_Comm comm,
                       const assembly::Products& products, EigenPairs& pairs) {
  const auto rows = pairs.vectors.rows();
  pairs.energy_residuals.assign(pairs.residuals.size(), 0.0);
  constexpr auto step = static_cast<std::size_t>(at_a_time);
  std::vector<Eigen::Index> doubtful;
  for (std::size_t k = 0; k < pairs.residuals.size(); ++k) {
    if (pairs.residuals[k] <= target_residual || is_rigid(pairs.values[k], shifted)) continue;
    doubtful.push_back(static_cast<Eigen::Index>(k));
  }
  for (std::size_t first = 0; first < doubtful.size(); first += step) {
    const auto columns = std::min(step, doubtful.size() - first);
    const std::span<const Eigen::Index> block(&doubtful[first], columns);
    const auto width = static_cast<Eigen::Index>(columns);
    Eigen::MatrixXd residual(rows, width), solved(rows, width);
    products.shifted(shifted.shift, pairs.vectors(Eigen::all, block), residual);
    for (std::size_t i = 0; i < columns; ++i) {
      const auto k = static_cast<std::size_t>(block[i]);
      residual.col(static_cast<Eigen::Index>(i)) -=
          (pairs.values[k] - shifted.shift) * pairs.mass_vectors.col(block[i]);
    }
    shifted.preconditioner(residual, solved);
    Eigen::ArrayXd square = residual.cwiseProduct(solved).colwise().sum().transpose();
    MPI_Allreduce(MPI_IN_PLACE, square.data(), static_cast<int>(columns), MPI_DOUBLE, MPI_SUM,
                  comm);
    for (std::size_t i = 0; i < columns; ++i) {
      const auto k = static_cast<std::size_t>(block[i]);
      const double energy = std::max(0.0, square[static_cast<Eigen::Index>(i)]);
      pairs.energy_residuals[k] = std::sqrt(energy / (pairs.values[k] - shifted.shift));
    }
  }
}

/// Fills residuals, mass_vectors and orthonormality from values and vectors.
void measure_residuals(double shift, MPI_Comm comm, const assembly::Products& products,
                       EigenPairs& pairs) {
  const auto rows = pairs.vectors.rows();
  pairs.mass_vectors.resize(rows, pairs.size());
  products.mass(pairs.vectors, pairs.mass_vectors);
  Eigen::ArrayXXd squares(2, pairs.size());
  Eigen::MatrixXd product(rows, at_a_time);
  for (Eigen::Index first = 0; first < pairs.size(); first += at_a_time) {
    const auto columns = std::min(at_a_time, pairs.size() - first);
    products.shifted(shift, pairs.vectors.middleCols(first, columns), product.leftCols(columns));
    for (Eigen::Index i = 0; i < columns; ++i) {
      const auto mass_vector = pairs.mass_vectors.col(first + i);
      const double value = pairs.values[static_cast<std::size_t>(first + i)];
      squares(0, first + i) = (product.col(i) - (value - shift) * mass_vector).squaredNorm();
      squares(1, first + i) = mass_vector.squaredNorm();
    }
  }
  Eigen::MatrixXd gram = pairs.vectors.transpose() * pairs.mass_vectors;
  MPI_Allreduce(MPI_IN_PLACE, squares.data(), static_cast<int>(squares.size()), MPI_DOUBLE, MPI_SUM,
                comm);
  MPI_Allreduce(MPI_IN_PLACE, gram.data(), static_cast<int>(gram.size()), MPI_DOUBLE, MPI_SUM,
                comm);
  pairs.residuals.clear();
  for (Eigen::Index k = 0; k < pairs.size(); ++k) {
    const double value = std::abs(pairs.values[static_cast<std::size_t>(k)]);
    pairs.residuals.push_back(std::sqrt(squares(0, k) / squares(1, k)) / value);
  }
  gram.diagonal().array() -= 1;
  pairs.orthonormality = gram.size() == 0 ? 0 : gram.cwiseAbs().maxCoeff();
}

/// A vector whose values lie in a column of a matrix.
VecHandle wrap(MPI_Comm comm, double* values, PetscInt rows) {
  VecHandle out;
  libraries::check(VecCreateMPIWithArray(comm, 3, rows, PETSC_DETERMINE, values, out.put()));
  return out;
}

/// By which of the eigensolvers an EPS solved: options may have chosen another.
modes::EigenSolver solver_of(EPS eps) {
  EPSType type = nullptr;
  libraries::check(EPSGetType(eps, &type));
  const std::string_view name = type;
  if (name == block_lanczos_type) return modes::EigenSolver::block_lanczos;
  if (name == EPSKRYLOVSCHUR) return modes::EigenSolver::krylov_schur;
  if (name == EPSLAPACK) return modes::EigenSolver::dense;
  return name == lobpcg_type ? modes::EigenSolver::lobpcg : modes::EigenSolver::slepc;
}

/// An EPS for the pairs next to a transformation's shift.
EpsHandle make_eps(const ShiftedSystem& shifted, EPSType type, int pairs, double tolerance,
                   MPI_Comm comm) {
  register_eps_types();
  EpsHandle eps;
  libraries::check(EPSCreate(comm, eps.put()));
  libraries::check(EPSSetST(eps.get(), shifted.transformation.get()));
  libraries::check(EPSSetProblemType(eps.get(), EPS_GHEP));
  libraries::check(EPSSetType(eps.get(), type));
  libraries::check(EPSSetTarget(eps.get(), shifted.shift));
  libraries::check(EPSSetWhichEigenpairs(eps.get(), EPS_TARGET_MAGNITUDE));
  libraries::check(EPSSetDimensions(eps.get(), pairs, PETSC_DETERMINE, PETSC_DETERMINE));
  libraries::check(EPSSetTolerances(eps.get(), tolerance, PETSC_DETERMINE));
  libraries::check(EPSSetPurify(eps.get(), PETSC_FALSE));
  return eps;
}

/// Lets options choose among solvers; the pairs that are sought are not theirs to choose.
void read_options(EPS eps, const ShiftedSystem& shifted) {
  libraries::check(EPSSetFromOptions(eps));
  double target = 0;
  EPSWhich which = EPS_TARGET_MAGNITUDE;
  libraries::check(EPSGetTarget(eps, &target));
  libraries::check(EPSGetWhichEigenpairs(eps, &which));
  if (target == shifted.shift && which == EPS_TARGET_MAGNITUDE) return;
  throw core::InputError("PETSC_OPTIONS asks for other eigenvalues than the lowest",
                         "leave out -eps_target and -eps_smallest_real and the like");
}

/// Pairs that an EPS finds, ascending.
/// @param remedy  of too few
EigenPairs solved(EPS eps, Eigen::Index rows, PetscInt wanted, const char* remedy, MPI_Comm comm) {
  libraries::check(EPSSolve(eps));
  PetscInt found = 0;
  libraries::check(EPSGetConverged(eps, &found));
  if (found < wanted) {
    PetscInt iterations = 0;
    libraries::check(EPSGetIterationNumber(eps, &iterations));
    throw core::SolverError(
        fmt::format("only {} of {} modes converged in {} iterations", found, wanted, iterations),
        remedy);
  }
  EigenPairs pairs;
  pairs.solver = solver_of(eps);
  pairs.vectors.resize(rows, found);
  for (PetscInt k = 0; k < found; ++k) {
    double value = 0;
    const auto x = wrap(comm, pairs.vectors.col(k).data(), static_cast<PetscInt>(rows));
    libraries::check(EPSGetEigenpair(eps, k, &value, nullptr, x.get(), nullptr));
    pairs.values.push_back(value);
  }
  return pairs;
}

/// With an inverse.
EigenPairs shift_inverted(const assembly::System& system, const EigenRequest& request,
                          const ShiftedSystem& shifted, MPI_Comm comm) {
  const bool is_stock = request.solver == modes::EigenSolver::krylov_schur;
  const auto wanted =
      static_cast<PetscInt>(std::min<std::int64_t>(request.pairs, system.free_unknowns()));
  const auto eps = make_eps(shifted, is_stock ? EPSKRYLOVSCHUR : block_lanczos_type, wanted,
                            request.tolerance, comm);
  if (is_stock) {
    // Beyond 150 modes the projected problem is held small, which bounds the basis' memory.
    const PetscInt projected = wanted > 150 ? 150 : PETSC_DETERMINE;
    libraries::check(EPSSetDimensions(eps.get(), wanted, PETSC_DETERMINE, projected));
    libraries::check(EPSSetTolerances(eps.get(), request.tolerance, 1000));
  } else if (request.basis > 0) {
    libraries::check(EPSSetDimensions(eps.get(), wanted, PETSC_DETERMINE, request.basis));
  }
  const assembly::Products products(system, comm);
  Eigen::VectorXd start(system.owned_unknowns());
  fill_start(system, request.seed, 0, start);
  const auto first = wrap(comm, start.data(), system.owned_unknowns());
  Vec space = first.get();
  libraries::check(EPSSetInitialSpace(eps.get(), 1, &space));
  read_options(eps.get(), shifted);
  set_space(eps.get(), {system.free_unknowns(),
                        // Written through: NOLINTNEXTLINE(performance-unnecessary-value-param)
                        [&](int number, Eigen::Ref<Eigen::VectorXd> out) {
                          fill_start(system, request.seed, number, out);
                        },
                        [&products](const auto& x, auto out) { products.mass(x, out); }});
  return solved(eps.get(), system.owned_unknowns(), wanted,
                "the mesh may have nearly flat elements; another element size often helps", comm);
}

/// With a preconditioner alone; rigid motions are known beforehand.
EigenPairs preconditioned(const assembly::System& system, const EigenRequest& request,
                          const ShiftedSystem& shifted, MPI_Comm comm) {
  const assembly::Products products(system, comm);
  const auto& rigid = shifted.rigid;
  Eigen::MatrixXd mass_rigid(rigid.rows(), rigid.cols());
  products.mass(rigid, mass_rigid);
  const auto room = static_cast<int>(system.unknowns() - rigid.cols());
  const int wanted = std::clamp(request.pairs - static_cast<int>(rigid.cols()), 1, room);
  const int guarded = std::min(wanted + guard_vectors, room);
  const LobpcgProblem problem = {&products,
                                 system.owned_unknowns(),
                                 system.unknowns(),
                                 shifted.shift,
                                 shifted.preconditioner,
                                 rigid,
                                 mass_rigid,
                                 comm};
  const auto eps = make_eps(shifted, lobpcg_type, wanted, request.tolerance, comm);
  read_options(eps.get(), shifted);
  if (solver_of(eps.get()) != modes::EigenSolver::lobpcg) {
    return shift_inverted(system, request, shifted, comm);
  }
  set_solve(eps.get(), [&](double tolerance, int max_iterations) {
    LobpcgOptions options;
    options.pairs = wanted;
    options.tolerance = tolerance;
    options.max_iterations = max_iterations;
    auto start = shifted.near_modes(guarded, request.seed);
    const auto known = std::min(request.start.cols(), start.cols());
    start.leftCols(known) = request.start.leftCols(known);
    return lobpcg(problem, options, start);
  });
  auto pairs = solved(eps.get(), system.owned_unknowns(), wanted,
                      "a direct solver (with a larger memory limit) or a mesh of better shaped "
                      "elements is needed",
                      comm);
  Eigen::MatrixXd stiffness_rigid(rigid.rows(), rigid.cols());
  products.shifted(0, rigid, stiffness_rigid);
  Eigen::MatrixXd turned = rigid.transpose() * stiffness_rigid;
  sum_alike(turned, comm);
  const Eigen::VectorXd zeros = eigenpairs_alike(turned, comm);
  pairs.values.resize(static_cast<std::size_t>(wanted));
  pairs.values.insert(pairs.values.begin(), zeros.data(), zeros.data() + zeros.size());
  Eigen::MatrixXd vectors(system.owned_unknowns(), rigid.cols() + wanted);
  vectors << rigid * turned, pairs.vectors.leftCols(wanted);
  pairs.vectors = std::move(vectors);
  return pairs;
}

/// Takes what the preconditioner makes of their residuals out of all vectors. The many sums that a
/// vector is made of leave rounding in directions of the stiffest motions, where it weighs most in
/// a residual and where this all but wipes it out.
void purify(const assembly::System& system, const ShiftedSystem& shifted, MPI_Comm comm,
            EigenPairs& pairs) {
  const assembly::Products products(system, comm);
  const auto rows = pairs.vectors.rows();
  for (Eigen::Index first = 0; first < pairs.size(); first += at_a_time) {
    const auto columns = std::min(at_a_time, pairs.size() - first);
    auto x = pairs.vectors.middleCols(first, columns);
    Eigen::MatrixXd residual(rows, columns), step(rows, columns);
    products.shifted(shifted.shift, x, residual);
    for (Eigen::Index k = 0; k < columns; ++k) {
      const double value = pairs.values[static_cast<std::size_t>(first + k)] - shifted.shift;
      residual.col(k) -= value * pairs.mass_vectors.col(first + k);
    }
    shifted.preconditioner(residual, step);
    x -= step;
  }
  // What an inexact inverse adds lies along the lowest vectors, so those are kept as they are.
  products.mass(pairs.vectors, pairs.mass_vectors);
  Eigen::MatrixXd gram = pairs.vectors.transpose() * pairs.mass_vectors;
  sum_alike(gram, comm);
  const Eigen::LLT<Eigen::MatrixXd> cholesky(gram);
  cholesky.matrixU().solveInPlace<Eigen::OnTheRight>(pairs.vectors);
}

/// The lowest eigenpairs of a small problem on one rank, by LAPACK (options -dense_eps_...).
void dense(const assembly::System& system, const EigenRequest& request, double shift,
           EigenPairs& pairs) {
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
        if (system.couples(static_cast<std::int32_t>(row), static_cast<std::int32_t>(column),
                           static_cast<int>(i))) {
          m(3 * row + i, 3 * column + i) = system.mass[static_cast<std::size_t>(begin + k)];
        }
      }
    }
  }
  a -= shift * m;
  // Roles exchanged: the largest eigenvalues of M x = nu (K - sigma M) x are the wanted ones, and
  // come out with the better accuracy.
  MatHandle mass, shifted_stiffness;
  const auto rows = static_cast<PetscInt>(n);
  libraries::check(MatCreateSeqDense(PETSC_COMM_SELF, rows, rows, m.data(), mass.put()));
  libraries::check(
      MatCreateSeqDense(PETSC_COMM_SELF, rows, rows, a.data(), shifted_stiffness.put()));
  const auto wanted =
      static_cast<PetscInt>(std::min<std::int64_t>(request.pairs, system.free_unknowns()));
  EpsHandle eps;
  libraries::check(EPSCreate(PETSC_COMM_SELF, eps.put()));
  libraries::check(EPSSetOptionsPrefix(eps.get(), "dense_"));
  libraries::check(EPSSetOperators(eps.get(), mass.get(), shifted_stiffness.get()));
  libraries::check(EPSSetProblemType(eps.get(), EPS_GHEP));
  libraries::check(EPSSetType(eps.get(), EPSLAPACK));
  libraries::check(EPSSetWhichEigenpairs(eps.get(), EPS_LARGEST_REAL));
  libraries::check(EPSSetDimensions(eps.get(), wanted, PETSC_DETERMINE, PETSC_DETERMINE));
  libraries::check(EPSSetFromOptions(eps.get()));
  pairs = solved(eps.get(), n, wanted, "the mesh may have elements that are nearly flat",
                 PETSC_COMM_SELF);
  const Eigen::Index kept = std::min<Eigen::Index>(wanted, pairs.vectors.cols());
  pairs.vectors.conservativeResize(Eigen::NoChange, kept);
  pairs.values.resize(static_cast<std::size_t>(kept));
  for (Eigen::Index k = 0; k < kept; ++k) {
    double& value = pairs.values[static_cast<std::size_t>(k)];
    pairs.vectors.col(k) /= std::sqrt(value);
    value = 1 / value + shift;
  }
}

/// Krylov methods want a space much larger than what is asked for.
bool wants_dense(std::int64_t unknowns, int pairs) {
  return unknowns <= 400 || (unknowns <= 2000 && 3 * static_cast<std::int64_t>(pairs) > unknowns);
}

}  // namespace

std::int64_t count_below(const assembly::System& system, double value, const FactorPlan& plan,
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

ShiftedSystem factor_shifted(const assembly::System& system, double shift, const FactorPlan& plan,
                             MPI_Comm comm, std::function<void()> before_solve) {
  ShiftedSystem shifted;
  shifted.shift = shift;
  shifted.transformation =
      factored_transformation(system, shift, plan, comm, std::move(before_solve));
  shifted.inverse = inverse_of(shifted.transformation);
  shifted.preconditioner = shifted.inverse;
  return shifted;
}

EigenPairs lowest_pairs(const assembly::System& system, const EigenRequest& request,
                        const ShiftedSystem& shifted, MPI_Comm comm) {
  EigenPairs pairs;
  if (size_of(comm) == 1 && wants_dense(system.free_unknowns(), request.pairs)) {
    dense(system, request, shifted.shift, pairs);
  } else if (shifted.near_modes && request.solver != modes::EigenSolver::krylov_schur) {
    pairs = preconditioned(system, request, shifted, comm);
  } else {
    pairs = shift_inverted(system, request, shifted, comm);
  }
  measure(system, shifted, comm, pairs);
  for (std::size_t k = 0; k < pairs.values.size(); ++k) {
    if (pairs.residuals[k] <= target_residual || is_rigid(pairs.values[k], shifted)) continue;
    purify(system, shifted, comm, pairs);
    measure(system, shifted, comm, pairs);
    break;
  }
  return pairs;
}

void measure(const assembly::System& system, const ShiftedSystem& shifted, MPI_Comm comm,
             EigenPairs& pairs) {
  const assembly::Products products(system, comm);
  measure_residuals(shifted.shift, comm, products, pairs);
  measure_in_energy(shifted, comm, products, pairs);
}

}  // namespace carillon::solvers::eigen
