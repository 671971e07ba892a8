#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/build/samples_task.hpp"
#include "cli/motion/cast.hpp"
#include "cli/motion/drawn_stylus.hpp"
#include "render/scene_frame.hpp"

namespace carillon::cli {

/// A take of a scene that moves, with everything that is needed to make it again.
struct Take {
  std::vector<Role> roles;
  TakeStage stage;
  synth::Motion motion;
  Sound sound;  ///< its audio is listeners x samples, gain applied
  std::vector<render::SceneFrame> frames;
  std::optional<TakeTouch> touch;
};

/// Makes takes: draws the cast, moves it, hears it and draws its frames.
class TakeMaker {
 public:
  /// @param trace  must outlive the maker, as config and plan must
  TakeMaker(const BuildConfig& config, const BuildPlan& plan, const BuildFolders& folders,
            core::Trace& trace);
  /// @param record  takes what the effects drew; may be null
  Take make(const Sample& sample, Columns* record);

 private:
  void hear(Take& take, const core::TimeLimit& clock);
  void draw(Take& take);

  const BuildConfig& config_;
  const BuildPlan& plan_;
  core::Trace& trace_;
  SoundChain chain_;
  Actors actors_;
  Textures textures_;
  std::shared_ptr<synth::TracedMaps> traced_ = std::make_shared<synth::TracedMaps>();
  RingingBody scene_;  ///< stands for all bodies: the origin, and listeners around it
};

}  // namespace carillon::cli
