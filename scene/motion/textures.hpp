#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "render/maps/surface_map.hpp"
#include "scene/motion/motion_config.hpp"
#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::scene::motion {

/// The maps of a configuration, each made once: images are read, others generated.
class Textures {
 public:
  explicit Textures(std::uint64_t seed) : seed_(seed) {}
  std::shared_ptr<const render::maps::SurfaceMap> of(const TextureConfig& texture);
  /// On a side of a body's box.
  /// @param surface  of the body; null: it fills its box
  /// @throws InputError  the side is not flat, or the relief half as deep as the body is thick
  render::maps::TexturedFace on(const TextureConfig& texture, const solvers::mesh::Box& box,
                                const solvers::mesh::SurfaceMesh* surface = nullptr);

 private:
  std::uint64_t seed_;
  std::map<std::string, std::shared_ptr<const render::maps::SurfaceMap>> maps_;
};

}  // namespace carillon::scene::motion
