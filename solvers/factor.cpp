#include "solvers/factor.hpp"

#include <fmt/core.h>

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"

namespace carillon::solvers {
namespace {

using IndexSet = core::Handle<IS, ISDestroy>;

/// Signs that MUMPS reports in INFOG(1) when a workspace estimate was too small.
constexpr PetscInt workspace_too_small = -8, main_workspace_too_small = -9;

/// A row-distributed AIJ matrix from CSR rows.
MatHandle from_rows(MPI_Comm comm, PetscInt rows, PetscInt block,
                    const std::vector<PetscInt>& first, const std::vector<PetscInt>& column,
                    const std::vector<double>& values) {
  MatHandle matrix;
  check(MatCreate(comm, matrix.put()));
  check(MatSetSizes(matrix.get(), rows, rows, PETSC_DETERMINE, PETSC_DETERMINE));
  check(MatSetBlockSize(matrix.get(), block));
  check(MatSetType(matrix.get(), MATAIJ));
  // Whichever does not fit the type does nothing.
  check(MatSeqAIJSetPreallocationCSR(matrix.get(), first.data(), column.data(), values.data()));
  check(MatMPIAIJSetPreallocationCSR(matrix.get(), first.data(), column.data(), values.data()));
  check(MatSetOption(matrix.get(), MAT_SYMMETRIC, PETSC_TRUE));
  check(MatSetOption(matrix.get(), MAT_SYMMETRY_ETERNAL, PETSC_TRUE));
  return matrix;
}

/// Elimination order of the unknowns: three to a node.
IndexSet unknown_order(std::span<const std::int32_t> node_order) {
  std::vector<PetscInt> order;
  order.reserve(3 * node_order.size());
  for (const auto node : node_order) {
    for (PetscInt c = 0; c < 3; ++c) order.push_back(3 * node + c);
  }
  IndexSet set;
  check(ISCreateGeneral(PETSC_COMM_SELF, static_cast<PetscInt>(order.size()), order.data(),
                        PETSC_COPY_VALUES, set.put()));
  check(ISSetPermutation(set.get()));
  return set;
}

void set_mumps_options(ScopedOptions& options, FactorMethod method, int workspace_percent,
                       PetscInt unknowns) {
  // Debian's MUMPS has neither METIS nor SCOTCH: asked for them it takes PORD without a word. An
  // order from outside is refused by PETSc's interface. PORD fills less on large bodies, but ends
  // the process on graphs that are nearly complete, so small ones are ordered by AMF.
  constexpr PetscInt large = 20000;
  options.set("mat_mumps_icntl_7", unknowns < large ? "2" : "4");
  options.set("mat_mumps_icntl_28", "1");
  options.set("mat_mumps_icntl_14", std::to_string(workspace_percent));
  if (method == FactorMethod::mumps_indefinite) {
    // The root front must not go to ScaLAPACK, which does not count its pivots' signs.
    options.set("mat_mumps_icntl_13", "1");
    options.set("mat_mumps_icntl_24", "1");
    options.set("mat_mumps_cntl_3", "1e-15");
  }
}

}  // namespace

MatHandle shifted_matrix(const System& system, double shift, bool definite, MPI_Comm comm) {
  const auto& graph = system.graph;
  if (system.stiffness.size() > static_cast<std::size_t>(std::numeric_limits<PetscInt>::max())) {
    throw core::SolverError(
        fmt::format("{} matrix entries on one rank are more than PETSc can count",
                    system.stiffness.size()),
        "use more ranks for this body, or a coarser mesh");
  }
  std::vector<PetscInt> first = {0}, column(system.stiffness.size());
  std::vector<double> values(system.stiffness);
  first.reserve(static_cast<std::size_t>(system.owned_unknowns()) + 1);
  for (std::size_t row = 0; row + 1 < graph.first.size(); ++row) {
    const auto begin = static_cast<std::size_t>(graph.first[row]);
    const auto width = static_cast<std::size_t>(graph.first[row + 1]) - begin;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto start = 9 * begin + i * 3 * width;
      for (std::size_t k = 0; k < width; ++k) {
        for (std::size_t j = 0; j < 3; ++j) {
          column[start + 3 * k + j] = 3 * graph.column[begin + k] + static_cast<PetscInt>(j);
        }
        values[start + 3 * k + i] -= shift * system.mass[begin + k];
      }
      first.push_back(static_cast<PetscInt>(start + 3 * width));
    }
  }
  auto matrix = from_rows(comm, system.owned_unknowns(), 3, first, column, values);
  if (definite) check(MatSetOption(matrix.get(), MAT_SPD, PETSC_TRUE));
  return matrix;
}

MatHandle mass_matrix(const System& system, MPI_Comm comm) {
  const std::vector<PetscInt> first(system.graph.first.begin(), system.graph.first.end());
  const std::vector<PetscInt> column(system.graph.column.begin(), system.graph.column.end());
  const auto pairs = from_rows(comm, system.graph.rows(), 1, first, column, system.mass);
  MatHandle mass;
  check(MatCreateMAIJ(pairs.get(), 3, mass.put()));
  return mass;
}

Factorization::Factorization(Mat matrix, FactorMethod method,
                             std::span<const std::int32_t> node_order) {
  int percent = 30;
  for (int tries = 0; tries < 4; ++tries, percent *= 2) {
    if (attempt(matrix, method, percent, node_order)) return;
  }
  throw core::SolverError("MUMPS: the workspace was too small even at eight times the first guess");
}

bool Factorization::attempt(Mat matrix, FactorMethod method, int workspace_percent,
                            std::span<const std::int32_t> node_order) {
  const bool cholmod = method == FactorMethod::cholmod;
  ScopedOptions options;
  if (cholmod) {
    // One method: the order that is given. Without one CHOLMOD tries AMD and METIS on the full
    // matrix, which has nine times the entries of the node graph.
    options.set("mat_cholmod_nmethods", node_order.empty() ? "0" : "1");
    options.set("mat_cholmod_factor", "SUPERNODAL");
  } else {
    PetscInt unknowns = 0;
    check(MatGetSize(matrix, &unknowns, nullptr));
    set_mumps_options(options, method, workspace_percent, unknowns);
  }
  check(MatSetOptionsPrefixFactor(matrix, options.prefix().c_str()));
  factor_ = MatHandle();
  check(MatGetFactor(matrix, cholmod ? MATSOLVERCHOLMOD : MATSOLVERMUMPS, MAT_FACTOR_CHOLESKY,
                     factor_.put()));
  IndexSet order;
  if (cholmod && !node_order.empty()) order = unknown_order(node_order);
  MatFactorInfo info;
  check(MatFactorInfoInitialize(&info));
  check(MatCholeskyFactorSymbolic(factor_.get(), matrix, order.get(), &info));
  check(MatCholeskyFactorNumeric(factor_.get(), matrix, &info));
  MatFactorError error = MAT_FACTOR_NOERROR;
  check(MatFactorGetError(factor_.get(), &error));
  if (error == MAT_FACTOR_NOERROR) return true;
  PetscInt status = 0, detail = 0;
  if (!cholmod) {
    check(MatMumpsGetInfog(factor_.get(), 1, &status));
    check(MatMumpsGetInfog(factor_.get(), 2, &detail));
    if (status == workspace_too_small || status == main_workspace_too_small) return false;
  }
  throw core::SolverError(
      fmt::format("the matrix could not be factored ({} INFOG(1) = {}, INFOG(2) = {})",
                  cholmod ? "CHOLMOD" : "MUMPS", status, detail),
      error == MAT_FACTOR_OUTMEMORY ? "the body needs more memory: use a coarser mesh or more ranks"
                                    : "the mesh may have elements that are nearly flat");
}

void Factorization::solve(const Eigen::Ref<const Eigen::MatrixXd>& right,
                          Eigen::Ref<Eigen::MatrixXd> solution) const {
  MPI_Comm comm = MPI_COMM_NULL;
  check(PetscObjectGetComm(reinterpret_cast<PetscObject>(factor_.get()), &comm));
  PetscInt unknowns = 0;
  check(MatGetSize(factor_.get(), &unknowns, nullptr));
  const auto rows = static_cast<PetscInt>(right.rows());
  const auto columns = static_cast<PetscInt>(right.cols());
  // PETSc wants columns without gaps.
  const Eigen::MatrixXd from = right;
  Eigen::MatrixXd to(right.rows(), right.cols());
  MatHandle in, out;
  check(MatCreateDense(comm, rows, PETSC_DECIDE, unknowns, columns,
                       const_cast<double*>(from.data()), in.put()));
  check(MatCreateDense(comm, rows, PETSC_DECIDE, unknowns, columns, to.data(), out.put()));
  check(MatMatSolve(factor_.get(), in.get(), out.get()));
  solution = to;
}

Inertia Factorization::inertia() const {
  PetscInt negative = 0, zero = 0, positive = 0;
  check(MatGetInertia(factor_.get(), &negative, &zero, &positive));
  return {negative, zero, positive};
}

}  // namespace carillon::solvers
