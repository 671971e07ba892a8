#pragma once

#include <mpi.h>

#include <filesystem>
#include <functional>
#include <limits>

#include "core/trace.hpp"
#include "solvers/mesher/mesh_child.hpp"
#include "solvers/pitch/pitch_target.hpp"

namespace carillon::scene {

/// Where meshes come from, and the bounds of a search for a pitch target.
struct PitchSearch {
  solvers::mesh::MeshRequest request;  ///< first setting, and max_elements for all
  double cents = 5;                    ///< the worst mode's pitch error may be so much
  solvers::modes::LinearSolver linear_solver = solvers::modes::LinearSolver::automatic;
  std::int64_t memory_limit = 16ll << 30;  ///< of a direct factor [byte]
  std::int64_t max_unknowns = std::numeric_limits<std::int64_t>::max();
  solvers::mesher::ChildLimits limits;
  std::filesystem::path cache;
};

/// Mode sets of a mesh, in judged_band() of their bands, that must all meet the target.
using SetSolver =
    std::function<std::vector<solvers::modes::Modes>(const solvers::mesh::MeshResult&)>;

/// Tetrahedra that a file gives (MSH) cannot be made smaller.
bool gives_tetrahedra(const solvers::mesh::MeshRequest& request);

/// The target that a search asks the solvers for.
solvers::pitch::PitchTarget pitch_target(const PitchSearch& search);

/// Meshes and solves an object until its pitches are as accurate as asked
/// (solvers::pitch::reach_pitch); every mesh that is tried stays in the cache. trace.stages["mesh"]
/// counts the meshes.
/// @param probe  the set whose modes are as far off as any's, alone (reach_pitch)
/// @note Collective on comm.
solvers::pitch::PitchResult refine_to_pitch(const PitchSearch& search, const SetSolver& solve,
                                            MPI_Comm comm, core::Trace& trace,
                                            const SetSolver& probe = {});

}  // namespace carillon::scene
