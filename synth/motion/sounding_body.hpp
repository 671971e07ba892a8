#pragma once

#include <optional>
#include <vector>

#include "synth/contact/acceleration_click.hpp"
#include "synth/radiation/equivalent_sources.hpp"
#include "synth/support/supports.hpp"

namespace carillon::synth::motion {

/// A string that holds a body: it damps its modes by its tension.
struct HoldingString {
  std::size_t number = 0;      ///< of the motion's
  Vec3 at = Vec3::Zero();      ///< body's coordinates [m]
  Vec3 anchor = Vec3::Zero();  ///< world [m]
  support::SupportKind kind;
};

/// What the sound of a moving body follows from; coordinates are those of its MovingBody.
struct SoundingBody {
  const solvers::modes::Modes* modes = nullptr;   ///< at the body's size; null: it makes no sound
  std::vector<double> decay_rates;                ///< of its material, and what it radiates [1/s]
  const radiation::SourceField* field = nullptr;  ///< its radiation, where there are listeners
  support::SupportKind rests;  ///< what a lasting contact is to it: dashpots per force (0: none)
  std::vector<HoldingString> strings;
  std::optional<contact::RigidSource> click;  ///< of a free body, where its click is asked for
};

}  // namespace carillon::synth::motion
