#pragma once

#include <mpi.h>

#include <filesystem>
#include <functional>

#include "core/trace.hpp"
#include "solvers/mesh_child.hpp"
#include "solvers/pitch_target.hpp"

namespace carillon::cli {

/// Where meshes come from, and the bounds of a search for a pitch target.
struct PitchSearch {
  solvers::MeshRequest request;  ///< first setting, and max_elements for all
  double cents = 5;              ///< the worst mode's pitch error may be so much
  solvers::LinearSolver linear_solver = solvers::LinearSolver::automatic;
  std::int64_t memory_limit = 16ll << 30;  ///< of a direct factor [byte]
  solvers::ChildLimits limits;
  std::filesystem::path cache;
};

/// Mode sets of a mesh, in judged_band() of their bands, that must all meet the target.
using SetSolver = std::function<std::vector<solvers::Modes>(const solvers::MeshResult&)>;

/// Tetrahedra that a file gives (MSH) cannot be made smaller.
bool gives_tetrahedra(const solvers::MeshRequest& request);

/// The target that a search asks the solvers for.
solvers::PitchTarget pitch_target(const PitchSearch& search);

/// Meshes and solves a body until its pitches are as accurate as asked (solvers::reach_pitch);
/// every mesh that is tried stays in the cache. trace.stages["mesh"] counts the meshes.
/// @note Collective on comm.
solvers::PitchResult refine_to_pitch(const PitchSearch& search, const SetSolver& solve,
                                     MPI_Comm comm, core::Trace& trace);

}  // namespace carillon::cli
