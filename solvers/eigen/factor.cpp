#include "solvers/eigen/factor.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "core/error.hpp"
#include "mpi/comm.hpp"
#include "solvers/eigen/detail/mumps.hpp"

namespace carillon::solvers::eigen {
namespace {

int size_of(MPI_Comm comm) {
  int size = 1;
  MPI_Comm_size(comm, &size);
  return size;
}

/// A row-distributed AIJ matrix from CSR rows.
MatHandle from_rows(MPI_Comm comm, PetscInt rows, PetscInt block,
                    const std::vector<PetscInt>& first, const std::vector<PetscInt>& column,
                    const std::vector<double>& values) {
  MatHandle matrix;
  libraries::check(MatCreate(comm, matrix.put()));
  libraries::check(MatSetSizes(matrix.get(), rows, rows, PETSC_DETERMINE, PETSC_DETERMINE));
  libraries::check(MatSetBlockSize(matrix.get(), block));
  libraries::check(MatSetType(matrix.get(), MATAIJ));
  // Whichever does not fit the type does nothing.
  libraries::check(
      MatSeqAIJSetPreallocationCSR(matrix.get(), first.data(), column.data(), values.data()));
  libraries::check(
      MatMPIAIJSetPreallocationCSR(matrix.get(), first.data(), column.data(), values.data()));
  libraries::check(MatSetOption(matrix.get(), MAT_SYMMETRIC, PETSC_TRUE));
  libraries::check(MatSetOption(matrix.get(), MAT_SYMMETRY_ETERNAL, PETSC_TRUE));
  return matrix;
}

/// The node graph of the whole body on rank 0; nothing on others.
assembly::NodeGraph gathered_graph(const assembly::System& system, MPI_Comm comm) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  const int size = size_of(comm);
  const auto& own = system.graph;
  std::vector<std::int32_t> widths;
  for (std::int32_t row = 0; row < own.rows(); ++row) {
    const auto r = static_cast<std::size_t>(row);
    widths.push_back(static_cast<std::int32_t>(own.first[r + 1] - own.first[r]));
  }
  std::vector<int> counts(static_cast<std::size_t>(size)), starts(counts);
  const auto nodes = static_cast<std::size_t>(rank == 0 ? system.partition.node_count() : 0);
  std::vector<std::int32_t> all_widths(nodes);
  for (int r = 0; r < size; ++r) {
    counts[static_cast<std::size_t>(r)] = system.partition.owned(r);
    starts[static_cast<std::size_t>(r)] = system.partition.first[static_cast<std::size_t>(r)];
  }
  MPI_Gatherv(widths.data(), own.rows(), MPI_INT32_T, all_widths.data(), counts.data(),
              starts.data(), MPI_INT32_T, 0, comm);
  assembly::NodeGraph whole;
  whole.first.assign(1, 0);
  for (const auto width : all_widths) whole.first.push_back(whole.first.back() + width);
  const auto pairs = static_cast<int>(own.column.size());
  MPI_Gather(&pairs, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, comm);
  std::exclusive_scan(counts.begin(), counts.end(), starts.begin(), 0);
  whole.column.resize(static_cast<std::size_t>(whole.first.back()));
  MPI_Gatherv(own.column.data(), pairs, MPI_INT32_T, whole.column.data(), counts.data(),
              starts.data(), MPI_INT32_T, 0, comm);
  return whole;
}

}  // namespace

MatHandle shifted_matrix(const assembly::System& system, double shift, bool definite,
                         MPI_Comm comm) {
  const auto& graph = system.graph;
  if (system.stiffness.size() > static_cast<std::size_t>(std::numeric_limits<PetscInt>::max())) {
    throw core::SolverError(
        fmt::format("{} matrix entries on one rank are more than PETSc can count",
                    system.stiffness.size()),
        "use more ranks for this object, or a coarser mesh");
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
        if (system.couples(graph.begin + static_cast<std::int32_t>(row), graph.column[begin + k],
                           static_cast<int>(i))) {
          values[start + 3 * k + i] -= shift * system.mass[begin + k];
        }
      }
      first.push_back(static_cast<PetscInt>(start + 3 * width));
    }
  }
  auto matrix = from_rows(comm, system.owned_unknowns(), 3, first, column, values);
  if (definite) libraries::check(MatSetOption(matrix.get(), MAT_SPD, PETSC_TRUE));
  return matrix;
}

MatHandle mass_matrix(const assembly::System& system, MPI_Comm comm) {
  assembly::System mass_alone = system;
  std::fill(mass_alone.stiffness.begin(), mass_alone.stiffness.end(), 0.0);
  return shifted_matrix(mass_alone, -1, true, comm);
}

FactorPlan plan_factors(const assembly::System& system, MPI_Comm comm) {
  FactorPlan plan;
  if (size_of(comm) == 1) {
    plan.node_order = assembly::nested_dissection(system.graph);
    plan.structure = std::make_shared<const CholeskyStructure>(system.graph, plan.node_order);
    return plan;
  }
  const auto whole = gathered_graph(system, comm);
  mpi::agreed_in_group(comm, [&] {
    if (whole.rows() > 0) plan.node_order = assembly::nested_dissection(whole);
  });
  return plan;
}

FactorSize predict_factor(const assembly::System& system, FactorPurpose purpose,
                          const FactorPlan& plan, MPI_Comm comm) {
  if (purpose == FactorPurpose::solve && plan.structure) return plan.structure->size();
  const bool solve = purpose == FactorPurpose::solve;
  return Mumps(system, solve ? Mumps::Purpose::solve : Mumps::Purpose::inertia, plan.node_order,
               comm)
      .size();
}

Inverse factored_inverse(const assembly::System& system, double shift, const FactorPlan& plan,
                         MPI_Comm comm) {
  if (plan.structure) {
    const auto factor = std::make_shared<const Cholesky>(system, shift, *plan.structure);
    return [factor](const Eigen::Ref<const Eigen::MatrixXd>& right,
                    // Written through: NOLINTNEXTLINE(performance-unnecessary-value-param)
                    Eigen::Ref<Eigen::MatrixXd> solution) { factor->solve(right, solution); };
  }
  const auto factor = std::make_shared<Mumps>(system, Mumps::Purpose::solve, plan.node_order, comm);
  factor->factor(shift);
  return [factor](const Eigen::Ref<const Eigen::MatrixXd>& right,
                  // Written through: NOLINTNEXTLINE(performance-unnecessary-value-param)
                  Eigen::Ref<Eigen::MatrixXd> solution) { factor->solve(right, solution); };
}

}  // namespace carillon::solvers::eigen
