#pragma once

#include "dataset/samples/cast.hpp"
#include "synth/touch/stylus.hpp"

namespace carillon::dataset::samples {

/// What a simulation's stylus felt, in the world's axes.
struct SimulationTouch {
  double rate = 0;           ///< [Hz]
  std::vector<Vec3> hand;    ///< [m], one a tick
  std::vector<Vec3> tip;     ///< [m]
  std::vector<Vec3> forces;  ///< of the face on the tip [N]
  std::size_t limited = 0, held_back = 0;
};

/// Draws the configuration's stylus over its face, from the simulation's start on, and adds it to
/// stage and motion as the last body, with its lasting contacts. Path and speed are drawn by (seed,
/// simulation's id, "motion.stylus"). The face's body must be fixed.
/// @param traced  maps traced for earlier simulations
SimulationTouch draw_stylus(const configuration::BuildConfig& config, std::uint64_t simulation_id,
                            SimulationStage& stage, synth::motion::Motion& motion,
                            const std::shared_ptr<synth::motion::TracedMaps>& traced);

/// A pen whose tip is the origin, leaning back from the way it is drawn.
solvers::mesh::SurfaceMesh pen_mesh();

}  // namespace carillon::dataset::samples
