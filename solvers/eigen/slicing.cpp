#include "solvers/eigen/slicing.hpp"

#include <fmt/core.h>
#include <slepceps.h>

#include <algorithm>

#include "core/error.hpp"
#include "solvers/eigen/detail/eps_types.hpp"

namespace carillon::solvers::eigen {
namespace {

/// Pairs that one shift is asked for at a time.
constexpr PetscInt pairs_per_shift = 24;

/// Options of the factorisations inside. They are set by name, as those set by call are lost when
/// a shift changes.
void set_factor_options(libraries::ScopedOptions& options, std::int64_t unknowns) {
  options.set("st_type", "sinvert");
  options.set("st_ksp_type", "preonly");
  options.set("st_pc_type", "cholesky");
  options.set("st_pc_factor_mat_solver_type", "mumps");
  // PORD fills less on large bodies, but ends the process on graphs that are nearly complete, so
  // small ones are ordered by AMF. Inertia needs the root front's pivots.
  options.set("st_mat_mumps_icntl_7", unknowns < 20000 ? "2" : "4");
  options.set("st_mat_mumps_icntl_28", "1");
  options.set("st_mat_mumps_icntl_14", "60");
  options.set("st_mat_mumps_icntl_13", "1");
  options.set("st_mat_mumps_icntl_24", "1");
  options.set("st_mat_mumps_cntl_3", "1e-15");
}

}  // namespace

EigenPairs slice_spectrum(const assembly::System& system, double low, double high, double tolerance,
                          MPI_Comm comm) {
  const auto stiffness = shifted_matrix(system, 0, false, comm);
  const auto mass = mass_matrix(system, comm);
  libraries::ScopedOptions options;
  set_factor_options(options, system.unknowns());
  EpsHandle eps;
  libraries::check(EPSCreate(comm, eps.put()));
  libraries::check(EPSSetOptionsPrefix(eps.get(), options.prefix().c_str()));
  libraries::check(EPSSetOperators(eps.get(), stiffness.get(), mass.get()));
  libraries::check(EPSSetProblemType(eps.get(), EPS_GHEP));
  libraries::check(EPSSetType(eps.get(), EPSKRYLOVSCHUR));
  libraries::check(EPSSetInterval(eps.get(), low, high));
  libraries::check(EPSSetWhichEigenpairs(eps.get(), EPS_ALL));
  libraries::check(EPSSetTolerances(eps.get(), tolerance, 200));
  const auto unknowns = static_cast<PetscInt>(system.free_unknowns());
  const auto pairs = std::min<PetscInt>(pairs_per_shift, std::max<PetscInt>(1, unknowns / 3));
  libraries::check(EPSKrylovSchurSetDimensions(eps.get(), pairs, PETSC_DETERMINE, PETSC_DETERMINE));
  libraries::check(EPSSetFromOptions(eps.get()));
  libraries::check(EPSSolve(eps.get()));
  EPSConvergedReason reason = EPS_CONVERGED_ITERATING;
  libraries::check(EPSGetConvergedReason(eps.get(), &reason));
  if (reason <= 0) {
    throw core::SolverError(
        fmt::format("spectrum slicing between {:.6g} and {:.6g} Hz did not "
                    "converge",
                    system.scales.to_frequency(low), system.scales.to_frequency(high)));
  }

  PetscInt found = 0;
  libraries::check(EPSGetConverged(eps.get(), &found));
  EigenPairs out;
  out.vectors.resize(system.owned_unknowns(), found);
  VecHandle vector;
  libraries::check(MatCreateVecs(stiffness.get(), vector.put(), nullptr));
  for (PetscInt k = 0; k < found; ++k) {
    double value = 0;
    libraries::check(EPSGetEigenpair(eps.get(), k, &value, nullptr, vector.get(), nullptr));
    out.values.push_back(value);
    const double* entries = nullptr;
    libraries::check(VecGetArrayRead(vector.get(), &entries));
    out.vectors.col(k) = Eigen::Map<const Eigen::VectorXd>(entries, out.vectors.rows());
    libraries::check(VecRestoreArrayRead(vector.get(), &entries));
  }
  return out;
}

}  // namespace carillon::solvers::eigen
