#include "routes.hpp"

#include <fmt/core.h>
#include <slepceps.h>

#include <algorithm>

#include "core/error.hpp"
#include "solvers/block_lanczos.hpp"
#include "solvers/eigen_solve.hpp"

namespace carillon::bench {

using namespace solvers;

Answer carillon_route(const System& system, double shift, int pairs) {
  Answer answer;
  FactorPlan plan;
  ShiftedSystem shifted;
  EigenPairs found;
  const EigenRequest request{pairs, 1e-12, 1};
  measure_stage(answer.stages, "order", [&] { plan = plan_factors(system, MPI_COMM_SELF); });
  measure_stage(answer.stages, "factor",
                [&] { shifted = factor_shifted(system, shift, plan, MPI_COMM_SELF); });
  measure_stage(answer.stages, "iterate",
                [&] { found = lowest_pairs(system, request, shifted, MPI_COMM_SELF); });
  shifted = ShiftedSystem();
  answer.values = found.values;
  // Between the pairs there must be room for a count.
  auto k = static_cast<std::size_t>(pairs);
  while (k > 7 && answer.values[k - 1] - answer.values[k - 2] < 1e-6 * answer.values[k - 1]) --k;
  const double between = (answer.values[k - 1] + answer.values[k - 2]) / 2;
  std::int64_t counted = 0;
  measure_stage(answer.stages, "count",
                [&] { counted = count_below(system, between, plan, MPI_COMM_SELF); });
  if (counted != static_cast<std::int64_t>(k) - 1) {
    throw core::Error(fmt::format("{} modes found, {} counted", k - 1, counted));
  }
  return answer;
}

namespace {

using EpsHandle = core::Handle<EPS, EPSDestroy>;

MatHandle assembled_mass(const System& system) {
  System mass = system;
  std::fill(mass.stiffness.begin(), mass.stiffness.end(), 0.0);
  return shifted_matrix(mass, -1, true, MPI_COMM_SELF);
}

}  // namespace

Answer slepc_route(const System& system, double shift, int pairs) {
  const auto stiffness = shifted_matrix(system, 0, false, MPI_COMM_SELF);
  const auto mass = assembled_mass(system);
  Answer answer;
  EpsHandle eps;
  check(EPSCreate(MPI_COMM_SELF, eps.put()));
  check(EPSSetOperators(eps.get(), stiffness.get(), mass.get()));
  check(EPSSetProblemType(eps.get(), EPS_GHEP));
  check(EPSSetType(eps.get(), EPSKRYLOVSCHUR));
  check(EPSSetTarget(eps.get(), shift));
  check(EPSSetWhichEigenpairs(eps.get(), EPS_TARGET_MAGNITUDE));
  check(EPSSetDimensions(eps.get(), pairs, PETSC_DEFAULT, PETSC_DEFAULT));
  check(EPSSetTolerances(eps.get(), 1e-12, 1000));
  ST st = nullptr;
  KSP ksp = nullptr;
  PC pc = nullptr;
  check(EPSGetST(eps.get(), &st));
  check(STSetType(st, STSINVERT));
  check(STSetMatStructure(st, SAME_NONZERO_PATTERN));
  check(STGetKSP(st, &ksp));
  check(KSPSetType(ksp, KSPPREONLY));
  check(KSPGetPC(ksp, &pc));
  check(PCSetType(pc, PCCHOLESKY));
  check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  measure_stage(answer.stages, "factor", [&] { check(EPSSetUp(eps.get())); });
  measure_stage(answer.stages, "iterate", [&] { check(EPSSolve(eps.get())); });
  PetscInt found = 0;
  check(EPSGetConverged(eps.get(), &found));
  for (PetscInt k = 0; k < found; ++k) {
    double value = 0;
    check(EPSGetEigenvalue(eps.get(), k, &value, nullptr));
    answer.values.push_back(value);
  }
  std::sort(answer.values.begin(), answer.values.end());
  return answer;
}

}  // namespace carillon::bench
