#pragma once

#include "cli/motion/cast.hpp"
#include "cli/motion/drawn_stylus.hpp"
#include "render/scene_frame.hpp"

namespace carillon::cli {

/// Part of both splits that a take is in: takes are held out as wholes.
std::string split_take(const BuildConfig& config, const Sample& sample);

/// Number of a part among SplitConfig::names().
std::size_t part_index(const BuildConfig& config, const std::string& part);

/// What a take looks like: its bodies in the order of the stage, but for the ground.
render::Scene picture_of(const TakeStage& stage, const MotionConfig& motion);

}  // namespace carillon::cli
