#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "cli/motion/motion_config.hpp"
#include "solvers/surface_mesh.hpp"
#include "solvers/textures/surface_map.hpp"

namespace carillon::cli {

/// The maps of a configuration, each made once: images are read, others generated.
class Textures {
 public:
  explicit Textures(std::uint64_t seed) : seed_(seed) {}
  std::shared_ptr<const solvers::SurfaceMap> of(const TextureConfig& texture);
  /// On a side of a body's box.
  /// @param surface  of the body; null: it fills its box
  /// @throws InputError  the side is not flat, or the relief half as deep as the body is thick
  solvers::TexturedFace on(const TextureConfig& texture, const solvers::Box& box,
                           const solvers::SurfaceMesh* surface = nullptr);

 private:
  std::uint64_t seed_;
  std::map<std::string, std::shared_ptr<const solvers::SurfaceMap>> maps_;
};

}  // namespace carillon::cli
