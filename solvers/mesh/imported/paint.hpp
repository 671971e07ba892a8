#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <span>
#include <vector>

#include "core/image.hpp"
#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::solvers::mesh::imported {

/// Base colours of a surface: linear reflectance, red, green and blue, 0 to 1.
struct Paint {
  struct Coat {
    Vec3 colour = Vec3::Ones();                  ///< a factor
    std::shared_ptr<const core::Image> picture;  ///< of sRGB; none: the factor alone
  };
  struct Face {
    std::size_t coat = 0;
    std::array<Eigen::Vector2d, 3> places{};  ///< in the picture, from its upper left corner
    std::array<Vec3, 3> colours{};            ///< of the corners, a factor
  };
  std::vector<Coat> coats;
  std::vector<Face> faces;  ///< one of each triangle

  /// Whether a picture of the body would look otherwise without it: something is not white.
  bool shows() const;
};

/// Colours at points on or near a surface: of the nearest place of the nearest face. Pictures
/// repeat beyond their borders and are interpolated between pixels in linear light.
/// @param surface  triangles that `paint` has a face of each
/// @return as many as points
std::vector<Vec3> colours_at(const SurfaceMesh& surface, const Paint& paint,
                             std::span<const Vec3> points);

}  // namespace carillon::solvers::mesh::imported
