#pragma once

#include <mpi.h>

#include <cstdint>
#include <span>

#include "core/time_limit.hpp"
#include "core/trace.hpp"
#include "solvers/elements/elastic.hpp"
#include "solvers/modes/modes.hpp"

namespace carillon::solvers::eigen {

struct SolveOptions {
  modes::Band band;
  double tolerance = 1e-12;  ///< of the transformed (shifted and inverted) problem
  modes::EigenSolver solver = modes::EigenSolver::block_lanczos;  ///< block_lanczos or krylov_schur
  modes::LinearSolver linear_solver = modes::LinearSolver::automatic;
  /// [byte] for all ranks of the group together. What the machine has free is never asked: it
  /// would let results depend on it.
  std::int64_t memory_limit = 16ll << 30;
  bool estimate_errors = true;  ///< fill Modes::pitch_errors
  bool mirror_planes = true;    ///< solve by classes where the mesh is symmetric (part_to_solve)
  /// Looked at between factorisations and in every step of an eigensolver; the first rank's clock
  /// counts. One factorisation cannot be stopped.
  core::TimeLimit time;
};

/// Modes of a free body by finite elements: K x = lambda M x, count by inertia, shift-and-invert
/// with the eigensolver and the linear solver that the options choose, then checks
/// (solver-independent units inside). Where modes are missing they are sought again, at last by
/// slicing the spectrum. The lowest `max_modes` flexible modes in the band, or all of them; none in
/// the band is a result like any other. A SolverEnvironment must be alive.
///
/// Pairs of equal frequency come with whatever basis the solver found. Each shape's sign makes the
/// largest of its entries on the surface positive.
///
/// @param mesh     the same on every rank of `comm`
/// @param regions  one for each of mesh.region_names
/// @param trace    stages partition, assemble, order, count, solve, slice (only where modes were
///                 missing), extract and estimate (only with estimate_errors) are added
/// @return the same on every rank
/// @throws InputError   nu outside (-1, 0.5), non-positive modulus or density, an empty band, no
///                      elements, or element nodes and regions that do not exist
/// @throws TimeError    options.time passed; MemoryError: an allocation failed
/// @throws SolverError  more memory than the limit, an element turned inside out, elements that
///                      overlap, no convergence,
///                      residual above 1e-6 (and above 1e-2 in the energy norm), wrong number of
///                      rigid modes, or parts that hang together by a point or an edge
/// @note Collective on comm.
modes::Modes solve_modes(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                         const SolveOptions& options, MPI_Comm comm, core::Trace& trace);

}  // namespace carillon::solvers::eigen
