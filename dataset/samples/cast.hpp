#pragma once

#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "dataset/samples/shape_modes.hpp"
#include "scene/chain.hpp"
#include "scene/motion/textures.hpp"
#include "synth/motion/sounding_body.hpp"

namespace carillon::dataset::samples {

/// A body at its size and of its material, as a motion needs it.
struct Actor {
  solvers::modes::Modes modes;  ///< as if it were free; those it has are `ringing`'s
  scene::RingingObject ringing;
  synth::surface::RigidBody rigid;
  std::vector<std::vector<Vec3>> hulls;              ///< at its size [m]
  double ball_radius = 0;                            ///< of a ball; 0: none
  std::optional<synth::contact::RigidSource> click;  ///< where clicks are heard
  solvers::mesh::SurfaceMesh surface;
  DrawnLooks looks;
  solvers::mesh::Box box;
};

/// Bodies that simulations are cast with, each made once.
class Actors {
 public:
  Actors(const configuration::BuildConfig& config, const plan::BuildPlan& plan,
         const BuildFolders& folders, scene::SoundChain& chain)
      : config_(config), plan_(plan), folders_(folders), chain_(chain) {}

  /// @param shape    its number in the plan
  /// @param held_by  what fixes it; null: it is free
  /// @throws FileError   its modes file is missing or damaged
  /// @throws InputError  it has no such variant, or no hull
  const Actor& of(std::size_t shape, const std::string& material, double size,
                  const std::shared_ptr<const scene::SupportsConfig>& held_by);

 private:
  const configuration::BuildConfig& config_;
  const plan::BuildPlan& plan_;
  BuildFolders folders_;
  scene::SoundChain& chain_;
  std::map<std::size_t, ShapeModes> shapes_;
  using Key = std::tuple<std::size_t, std::string, double, const scene::SupportsConfig*>;
  std::map<Key, std::unique_ptr<Actor>> actors_;
};

/// Who plays in a simulation: what was drawn for each body of the cast.
struct Role {
  std::string name;
  std::size_t shape = 0;
  std::string material;
  double size = 1;
  double release = 0;  ///< [s]
  synth::motion::BodyState start;
};

/// Whether an object's instances are kept to the simulations of their own part of split_shape.
/// Where a part would have none, simulations of all parts draw from all of them.
bool held_out(const configuration::BuildConfig& config, const plan::BuildPlan& plan,
              const std::string& object);

/// Draws a simulation: each body's instance (among those of the simulation's part where they are
/// held out), its material, place, turn and motion. Streams are keyed by (seed, simulation's id,
/// body's name).
/// @param part  of split_shape that the simulation is in
std::vector<Role> draw_roles(const configuration::BuildConfig& config, const plan::BuildPlan& plan,
                             std::uint64_t simulation_id, const std::string& part);

/// A simulation ready to move: the ground first, where there is one, then the cast. Numbers of
/// bodies are the same everywhere.
struct SimulationStage {
  std::vector<std::string> names;
  std::vector<const Actor*> actors;  ///< null: the ground
  std::vector<synth::motion::MovingBody> moving;
  std::vector<synth::motion::SoundingBody> sounding;
  std::vector<synth::motion::MotionString> strings;
};
SimulationStage set_stage(const configuration::BuildConfig& config, const std::vector<Role>& roles,
                          Actors& actors, scene::motion::Textures& textures);

}  // namespace carillon::dataset::samples
