#pragma once

#include <optional>
#include <vector>

#include "synth/acceleration_click.hpp"
#include "synth/equivalent_sources.hpp"
#include "synth/supports.hpp"

namespace carillon::synth {

/// What the sound of a moving body follows from; coordinates are those of its MovingBody.
struct SoundingBody {
  const solvers::Modes* modes = nullptr;  ///< at the body's size; null: it makes no sound
  std::vector<double> decay_rates;        ///< of its material, and what it radiates [1/s]
  const SourceField* field = nullptr;     ///< its radiation, where there are listeners
  SupportKind rests;  ///< what a lasting contact is to it: dashpots per force (0: none)
  std::optional<RigidSource> click;  ///< of a free body, where its click is asked for
};

}  // namespace carillon::synth
