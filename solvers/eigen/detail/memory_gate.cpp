#include "solvers/eigen/detail/memory_gate.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/progress.hpp"
#include "solvers/eigen/detail/lobpcg.hpp"
#include "solvers/eigen/eigen_solve.hpp"
#include "solvers/eigen/pitch_error.hpp"

namespace carillon::solvers::eigen {
namespace {

std::int64_t kept(const FactorSize& factor) {
  return static_cast<std::int64_t>(sizeof(double)) * factor.entries;
}

std::string size_text(std::int64_t bytes) {
  return core::human_binary_bytes(static_cast<double>(bytes));
}

/// K and M of a level below, of order 2 below 3: about a quarter.
std::int64_t with_coarser(std::int64_t system) {
  return system + system / 4;
}

/// Solving and estimating take turns.
std::int64_t work(const MemoryNeeds& needs, bool iterative) {
  const auto vectors = iterative ? needs.iterative_vectors : needs.vectors;
  return std::max(vectors, needs.pairs + needs.estimate);
}

/// Columns on their way through the solvers, eight at a time on every level.
constexpr std::int64_t work_columns = 80;

}  // namespace

void weigh_vectors(const assembly::System& system, std::int64_t pairs, MemoryNeeds& needs) {
  const auto column = system.unknowns() * static_cast<std::int64_t>(sizeof(double));
  // Krylov methods hold up to three times as many vectors as they find, or 150 and an eighth more;
  // the pairs come beside them with M times each.
  const auto basis = pairs + std::min(2 * pairs, 150 + pairs / 8);
  needs.pairs = 2 * pairs * column;
  needs.vectors = needs.pairs + (basis + work_columns) * column;
  needs.iterative_vectors = std::max(
      needs.vectors, needs.pairs + (lobpcg_vectors(pairs + guard_vectors) + work_columns) * column);
}

MemoryNeeds memory_needs(const mesh::TetMesh& mesh, const assembly::System& system,
                         const SolveOptions& options, const FactorPlan& plan, std::int64_t pairs,
                         MPI_Comm comm) {
  MemoryNeeds needs;
  const auto own = sizeof(double) * (system.stiffness.size() + system.mass.size()) +
                   sizeof(std::int32_t) * system.graph.column.size();
  needs.system = static_cast<std::int64_t>(own);
  MPI_Allreduce(MPI_IN_PLACE, &needs.system, 1, MPI_INT64_T, MPI_SUM, comm);
  weigh_vectors(system, pairs, needs);
  if (options.estimate_errors) needs.estimate = min_estimate_bytes(mesh, comm);
  if (options.linear_solver == modes::LinearSolver::iterative) return needs;
  const double bound = 200 * std::pow(static_cast<double>(system.unknowns()), 4.0 / 3);
  const double limit =
      static_cast<double>(options.memory_limit - needs.system - work(needs, false));
  if (2 * 8 * bound < limit) return needs;
  needs.solve = predict_factor(system, FactorPurpose::solve, plan, comm);
  needs.count = predict_factor(system, FactorPurpose::count, plan, comm);
  return needs;
}

MemoryDecision decide(const MemoryNeeds& needs, modes::LinearSolver asked, std::int64_t limit) {
  MemoryDecision decision;
  const auto base = needs.system + needs.vectors;
  const auto held = needs.system + kept(needs.solve) + work(needs, false);
  if (asked != modes::LinearSolver::iterative &&
      std::max(base + needs.solve.bytes, held) <= limit) {
    decision.counts = needs.system + needs.pairs + needs.count.bytes <= limit;
    decision.both_fit = base + kept(needs.solve) + needs.count.bytes <= limit;
    return decision;
  }
  const auto iterative = with_coarser(needs.system) + work(needs, true);
  const auto ways_out =
      fmt::format("use a coarser mesh (a larger element size){}, or raise the memory limit",
                  asked == modes::LinearSolver::direct ? ", the iterative linear solver" : "");
  if (asked == modes::LinearSolver::direct) {
    throw core::SolverError(
        fmt::format("a factor of {:.2g} entries takes {} beside {} of matrices and {} of vectors "
                    "and estimates, "
                    "more than the memory limit of {}",
                    static_cast<double>(needs.solve.entries), size_text(needs.solve.bytes),
                    size_text(needs.system), size_text(work(needs, false)), size_text(limit)),
        ways_out);
  }
  if (iterative > limit) {
    throw core::SolverError(fmt::format("{} of matrices and {} of vectors and estimates are more "
                                        "than the memory limit of {} even "
                                        "without a factor",
                                        size_text(with_coarser(needs.system)),
                                        size_text(work(needs, true)), size_text(limit)),
                            ways_out + ", or ask for fewer modes");
  }
  decision.linear_solver = modes::LinearSolver::iterative;
  decision.counts = false;
  decision.both_fit = false;
  decision.coarse_factor = room_for_coarse(needs, limit);
  return decision;
}

std::int64_t room_for_coarse(const MemoryNeeds& needs, std::int64_t limit) {
  return limit - with_coarser(needs.system) - work(needs, true);
}

void refuse_large_basis(const MemoryNeeds& needs, const MemoryDecision& decision,
                        std::int64_t limit) {
  const bool iterative = decision.linear_solver == modes::LinearSolver::iterative;
  const auto held = iterative ? with_coarser(needs.system) : needs.system + kept(needs.solve);
  const auto vectors = work(needs, iterative);
  if (held + vectors <= limit) return;
  throw core::SolverError(
      fmt::format(
          "{} of vectors and estimates do not fit beside {} of matrices{}: the memory limit is {}",
          size_text(vectors), size_text(held), iterative ? "" : " and factor", size_text(limit)),
      "ask for fewer modes, use a coarser mesh, or raise the memory limit");
}

std::int64_t left_for_estimates(const MemoryNeeds& needs, const MemoryDecision& decision,
                                std::int64_t limit) {
  const bool iterative = decision.linear_solver == modes::LinearSolver::iterative;
  const auto held = iterative ? with_coarser(needs.system) + decision.coarse_factor
                              : needs.system + kept(needs.solve);
  return std::max(limit - held - needs.pairs, needs.estimate);
}

bool slices_fit(const MemoryNeeds& needs, std::int64_t limit) {
  // Matrices once more in PETSc's own form; L D L^T pivots into more entries than Cholesky has.
  return 2 * needs.system + needs.pairs + 2 * needs.solve.bytes <= limit;
}

}  // namespace carillon::solvers::eigen
