#pragma once

#include <mpi.h>

#include <cstdint>
#include <span>

#include "solvers/eigen_solve.hpp"

namespace carillon::solvers {

/// One multigrid cycle for K - shift M (shift < 0) through polynomials of falling degree: Chebyshev
/// smoothing of the fourth kind (Lottes 2023, Numer. Linear Algebra Appl. 30, e2518) over the
/// blocks of each node, order 2 below orders 3 and 4, order 1 below that, and on the coarsest level
/// a direct factor where it fits, else a cycle of algebraic multigrid (PETSc's GAMG) with the rigid
/// motions as near-null space. Algebraic multigrid alone is weak on elements of high order, and
/// order 1 alone is too stiff for thin walls.
///
/// @param component     of every mesh node (node_components)
/// @param factor_bytes  [byte] that a factor on a coarser level may take, all ranks together
/// @return symmetric positive definite; refers to `system`
/// @throws core::SolverError  a coarse level cannot be set up
/// @note Collective on comm.
Inverse multigrid_cycle(const TetMesh& mesh, std::span<const Elastic> regions, const System& system,
                        const std::vector<std::int32_t>& component, double shift,
                        std::int64_t factor_bytes, MPI_Comm comm);

}  // namespace carillon::solvers
