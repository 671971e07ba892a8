#pragma once

#include <filesystem>
#include <span>

#include "core/trace.hpp"
#include "mpi/comm.hpp"
#include "solvers/basis/solve_materials.hpp"
#include "solvers/pitch/pitch_target.hpp"

namespace carillon::scene {

/// How bodies of revolution are solved.
struct TurnedOptions {
  solvers::eigen::SolveOptions solve;  ///< tolerance, time and estimate_errors
  double pitch_cents = 0;              ///< refined until the worst mode is within it; 0: not
  double cell = 0;                     ///< largest side of a cell [m]; 0: chosen
};

/// Size of a generated body of revolution [m].
double longest_side_of_turned(const solvers::mesh::GeneratedShape& shape);

/// Mode sets of a generated body of revolution by the axisymmetric solver on the first rank, on one
/// surface, behind the cache (empty path: none). There are no tetrahedra: PitchResult::mesh keeps
/// the name of the one region, and the report of a target has no steps.
/// @return the same on every rank
/// @throws as solve_axisymmetric
/// @note Collective on comm.
solvers::pitch::PitchResult solve_turned(const solvers::mesh::GeneratedShape& shape,
                                         std::span<const solvers::basis::ModeRequest> sets,
                                         const TurnedOptions& options, MPI_Comm comm,
                                         const std::filesystem::path& cache, core::Trace& trace);

}  // namespace carillon::scene
