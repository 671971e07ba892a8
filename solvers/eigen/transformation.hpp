#pragma once

#include <mpi.h>
#include <slepcst.h>

#include <functional>
#include <memory>
#include <type_traits>

#include "solvers/eigen/factor.hpp"

namespace carillon::solvers::eigen {

/// K and M of a System and the transformation (K - sigma M)^-1 M, as SLEPc knows them. PETSc counts
/// who holds it.
using Transformation = std::shared_ptr<std::remove_pointer_t<ST>>;

/// By a Cholesky factor, ready to solve with. K, M and K - sigma M are shells that multiply
/// straight from the System's rows; the factor is PETSc's solver package "carillon" for them
/// (CHOLMOD on one rank, MUMPS on a group, METIS' order), which solves for many columns at a time
/// (MatMatSolve). Options in PETSC_OPTIONS that ask for another preconditioner or package
/// (-st_pc_type, -st_pc_factor_mat_solver_type) get assembled matrices.
///
/// @param system        is referred to and must live as long
/// @param before_solve  is called before each solve with this factor; may throw, alike on every
/// rank
/// @throws core::SolverError  not positive definite, or out of memory
/// @throws core::InputError   options ask for another transformation, shift or mode of matrices
/// @note Collective on comm, as are all solves.
Transformation factored_transformation(const assembly::System& system, double shift,
                                       const FactorPlan& plan, MPI_Comm comm,
                                       std::function<void()> before_solve = {});

/// By an inverse that is there: a shell preconditioner that is all of the solve.
Transformation given_transformation(const assembly::System& system, double shift, Inverse inverse,
                                    MPI_Comm comm);

/// Solves with a transformation's K - sigma M, all columns together (KSPMatSolve).
Inverse inverse_of(const Transformation& transformation);

}  // namespace carillon::solvers::eigen
