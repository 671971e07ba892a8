#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cli/context.hpp"
#include "cli/object_options.hpp"
#include "scene/live/live_scene.hpp"

namespace carillon::cli {

/// What is played, as typed.
struct PlayedWhat {
  std::vector<std::string> what;  ///< objects, or one configuration (.yaml, .yml)
  ObjectOptions object;           ///< of the objects, but for their names
  std::string scene;              ///< configuration whose scene is taken; "": none
  std::vector<std::string> overrides;
  std::uint64_t seed = 1;
  std::size_t max_objects = 500;
};

/// Objects that can be played, and the scene that they are heard in.
struct PlayedObjects {
  scene::Scene scene;
  std::vector<scene::live::LiveObject> objects;
};

/// Solves what is asked for, through the cache: objects, or every object of a configuration in each
/// of its materials and sizes.
/// @param keys  of the scene, as key=value, that options stand for; --set comes after them
/// @throws ConfigError, InputError  and as the solvers do; more than max_objects
PlayedObjects played_objects(PlayedWhat what, std::vector<std::string> keys,
                             const Context& context);

}  // namespace carillon::cli
