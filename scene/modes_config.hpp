#pragma once

#include "core/config.hpp"
#include "scene/solved_object.hpp"

namespace carillon::scene {

/// How modes are found, as the mappings `modes` and `solver` of a configuration say.
struct ModesConfig {
  solvers::modes::Band band;
  SolverRequest object_solver;          ///< of objects that name none
  solvers::eigen::SolveOptions solver;  ///< all but the band
  solvers::mesh::MeshOptions mesh;
  /// Each shape is refined until its worst mode is within it; 0: not.
  double pitch_cents = solvers::pitch::usual_pitch_target;
  std::int64_t max_unknowns = solvers::pitch::usual_max_unknowns;  ///< of such refinements
};

/// Reads `modes:`, before `solver:`.
/// @param sample_rate  of the sounds [Hz]: modes at or above half of it would not sound
/// @throws ConfigError
void read_modes(core::ConfigNode modes, double sample_rate, ModesConfig& config);

/// Reads `solver:`.
/// @throws ConfigError
void read_solver(core::ConfigNode solver, ModesConfig& config);

/// What they ask for of one object.
/// @param mesh  its shape; its options become those of the configuration
ObjectRequest object_request(const ModesConfig& config, solvers::mesh::MeshRequest mesh,
                             RegionMaterials materials);

}  // namespace carillon::scene
