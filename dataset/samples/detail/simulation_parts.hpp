#pragma once

#include "dataset/samples/cast.hpp"
#include "dataset/samples/drawn_stylus.hpp"
#include "render/scene_frame.hpp"

namespace carillon::dataset::samples {

/// Part of both splits that a simulation is in: simulations are held out as wholes.
std::string split_of_simulation(const configuration::BuildConfig& config,
                                const plan::Sample& sample);

/// Number of a part among SplitConfig::names().
std::size_t part_index(const configuration::BuildConfig& config, const std::string& part);

/// What a simulation looks like: its bodies in the order of the stage, but for the ground.
render::Scene picture_of(const SimulationStage& stage, const configuration::BuildConfig& config);

}  // namespace carillon::dataset::samples
