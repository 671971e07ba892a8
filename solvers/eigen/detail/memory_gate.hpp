#pragma once

#include <mpi.h>

#include <cstdint>

#include "solvers/eigen/factor.hpp"
#include "solvers/eigen/solve_modes.hpp"

namespace carillon::solvers::eigen {

/// What the parts of a solve take [byte], all ranks of the group together.
struct MemoryNeeds {
  std::int64_t system = 0;    ///< K and M
  std::int64_t vectors = 0;   ///< the eigensolver's basis, the pairs, and columns on their way
  std::int64_t pairs = 0;     ///< what is kept of them
  std::int64_t estimate = 0;  ///< pitch errors, estimated when only the pairs are left
  FactorSize solve;           ///< factor that solves: most while it is made
  FactorSize count;           ///< factor that inertia is read from, let go as it is made
  std::int64_t iterative_vectors = 0;  ///< in place of `vectors` where linear solves are iterative
};

/// How a body is solved within its memory.
struct MemoryDecision {
  modes::LinearSolver linear_solver = modes::LinearSolver::direct;  ///< direct or iterative
  bool counts = true;    ///< modes can be counted by inertia
  bool both_fit = true;  ///< a count's factor fits beside the one that solves
  /// [byte] that a factor on a coarser level of an iterative solver may take.
  std::int64_t coarse_factor = 0;
};

/// Direct while the factor that solves fits, counted while the one that counts does; else iterative
/// where that is allowed.
/// @throws core::SolverError  neither: names what would be needed, and the ways out
MemoryDecision decide(const MemoryNeeds& needs, modes::LinearSolver asked, std::int64_t limit);

/// @param needs  with the vectors of as many pairs as are really asked for
/// @throws core::SolverError  they do not fit beside what a decision holds
void refuse_large_basis(const MemoryNeeds& needs, const MemoryDecision& decision,
                        std::int64_t limit);

/// [byte] that an iterative solver's factor on a coarser level may take beside these needs.
std::int64_t room_for_coarse(const MemoryNeeds& needs, std::int64_t limit);

/// What estimates may take beside all that is held while they are made.
std::int64_t left_for_estimates(const MemoryNeeds& needs, const MemoryDecision& decision,
                                std::int64_t limit);
/// Whether a second factor, kept with its entries by L D L^T, fits beside matrices and pairs.
bool slices_fit(const MemoryNeeds& needs, std::int64_t limit);

/// Needs from the analyses of the factors, which are not made. Bodies whose factors are far below
/// the limit (200 n^(4/3) entries, four times what nested dissection leaves of solid bodies) are
/// not analysed for it: theirs stand as 0.
/// @param plan   empty where only the iterative solver may be used: factors are then not looked at
/// @param pairs  eigenpairs that are asked for
/// @return the same on every rank; depends on the matrix and the options alone, never on what the
///         machine has free
/// @note Collective on comm.
MemoryNeeds memory_needs(const mesh::TetMesh& mesh, const assembly::System& system,
                         const SolveOptions& options, const FactorPlan& plan, std::int64_t pairs,
                         MPI_Comm comm);

/// Sets vectors, iterative_vectors and pairs for so many pairs.
void weigh_vectors(const assembly::System& system, std::int64_t pairs, MemoryNeeds& needs);

}  // namespace carillon::solvers::eigen
