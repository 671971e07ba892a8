#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dataset/samples/cast.hpp"
#include "dataset/samples/drawn_stylus.hpp"
#include "dataset/samples/samples_task.hpp"
#include "render/scene_frame.hpp"

namespace carillon::dataset::samples {

/// A simulation of a scene that moves, with everything that is needed to make it again.
struct Simulation {
  std::vector<Role> roles;
  SimulationStage stage;
  synth::motion::Motion motion;
  scene::Sound sound;  ///< its audio is listeners x samples, gain applied
  std::vector<render::SceneFrame> frames;
  std::optional<SimulationTouch> touch;
};

/// Makes simulations: draws the cast, moves it, hears it and draws its frames.
class SimulationMaker {
 public:
  /// @param trace  must outlive the maker, as config and plan must
  SimulationMaker(const configuration::BuildConfig& config, const plan::BuildPlan& plan,
                  const BuildFolders& folders, core::Trace& trace);
  /// @param record  takes what the effects drew; may be null
  Simulation make(const plan::Sample& sample, core::Columns* record);

 private:
  void hear(Simulation& simulation, const core::TimeLimit& clock);
  void draw(Simulation& simulation);

  const configuration::BuildConfig& config_;
  const plan::BuildPlan& plan_;
  core::Trace& trace_;
  scene::SoundChain chain_;
  Actors actors_;
  scene::motion::Textures textures_;
  std::shared_ptr<synth::motion::TracedMaps> traced_ =
      std::make_shared<synth::motion::TracedMaps>();
  scene::RingingObject scene_;  ///< stands for all bodies: the origin, and listeners around it
};

}  // namespace carillon::dataset::samples
