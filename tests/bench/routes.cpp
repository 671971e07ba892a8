#include "routes.hpp"

#include <fmt/core.h>
#include <slepceps.h>

#include <algorithm>

#include "core/error.hpp"
#include "solvers/eigen/detail/block_lanczos.hpp"
#include "solvers/eigen/eigen_solve.hpp"

namespace carillon::bench {

using namespace solvers;

Answer carillon_route(const solvers::assembly::System& system, double shift, int pairs) {
  Answer answer;
  solvers::eigen::FactorPlan plan;
  solvers::eigen::ShiftedSystem shifted;
  solvers::eigen::EigenPairs found;
  const solvers::eigen::EigenRequest request{pairs, 1e-12, 1};
  measure_stage(answer.stages, "order",
                [&] { plan = solvers::eigen::plan_factors(system, MPI_COMM_SELF); });
  measure_stage(answer.stages, "factor", [&] {
    shifted = solvers::eigen::factor_shifted(system, shift, plan, MPI_COMM_SELF);
  });
  measure_stage(answer.stages, "iterate", [&] {
    found = solvers::eigen::lowest_pairs(system, request, shifted, MPI_COMM_SELF);
  });
  shifted = solvers::eigen::ShiftedSystem();
  answer.values = found.values;
  // Between the pairs there must be room for a count.
  auto k = static_cast<std::size_t>(pairs);
  while (k > 7 && answer.values[k - 1] - answer.values[k - 2] < 1e-6 * answer.values[k - 1]) --k;
  const double between = (answer.values[k - 1] + answer.values[k - 2]) / 2;
  std::int64_t counted = 0;
  measure_stage(answer.stages, "count", [&] {
    counted = solvers::eigen::count_below(system, between, plan, MPI_COMM_SELF);
  });
  if (counted != static_cast<std::int64_t>(k) - 1) {
    throw core::Error(fmt::format("{} modes found, {} counted", k - 1, counted));
  }
  return answer;
}

namespace {

using EpsHandle = core::Handle<EPS, EPSDestroy>;

}  // namespace

Answer slepc_route(const solvers::assembly::System& system, double shift, int pairs) {
  const auto stiffness = solvers::eigen::shifted_matrix(system, 0, false, MPI_COMM_SELF);
  const auto mass = solvers::eigen::mass_matrix(system, MPI_COMM_SELF);
  Answer answer;
  EpsHandle eps;
  solvers::libraries::check(EPSCreate(MPI_COMM_SELF, eps.put()));
  solvers::libraries::check(EPSSetOperators(eps.get(), stiffness.get(), mass.get()));
  solvers::libraries::check(EPSSetProblemType(eps.get(), EPS_GHEP));
  solvers::libraries::check(EPSSetType(eps.get(), EPSKRYLOVSCHUR));
  solvers::libraries::check(EPSSetTarget(eps.get(), shift));
  solvers::libraries::check(EPSSetWhichEigenpairs(eps.get(), EPS_TARGET_MAGNITUDE));
  solvers::libraries::check(EPSSetDimensions(eps.get(), pairs, PETSC_DETERMINE, PETSC_DETERMINE));
  solvers::libraries::check(EPSSetTolerances(eps.get(), 1e-12, 1000));
  ST st = nullptr;
  KSP ksp = nullptr;
  PC pc = nullptr;
  solvers::libraries::check(EPSGetST(eps.get(), &st));
  solvers::libraries::check(STSetType(st, STSINVERT));
  solvers::libraries::check(STSetMatStructure(st, SAME_NONZERO_PATTERN));
  solvers::libraries::check(STGetKSP(st, &ksp));
  solvers::libraries::check(KSPSetType(ksp, KSPPREONLY));
  solvers::libraries::check(KSPGetPC(ksp, &pc));
  solvers::libraries::check(PCSetType(pc, PCCHOLESKY));
  solvers::libraries::check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  measure_stage(answer.stages, "factor", [&] { solvers::libraries::check(EPSSetUp(eps.get())); });
  measure_stage(answer.stages, "iterate", [&] { solvers::libraries::check(EPSSolve(eps.get())); });
  PetscInt found = 0;
  solvers::libraries::check(EPSGetConverged(eps.get(), &found));
  for (PetscInt k = 0; k < found; ++k) {
    double value = 0;
    solvers::libraries::check(EPSGetEigenvalue(eps.get(), k, &value, nullptr));
    answer.values.push_back(value);
  }
  std::sort(answer.values.begin(), answer.values.end());
  return answer;
}

}  // namespace carillon::bench
