#pragma once

#include <Eigen/Geometry>

#include "render/detail/drawing.hpp"

namespace carillon::render {

/// Where a body's flat side lies within, and just beyond, the rectangle that a map takes on it.
struct Footprint {
  Texture inside;                   ///< 1 where there is face, over the rectangle and its margin
  Eigen::Vector2d margin = {0, 0};  ///< beyond each side of the rectangle [m]
  bool whole = true;                ///< all of the rectangle is face
  bool goes_on = false;             ///< there is face beyond it
};

/// Where a footprint is drawn; made once for each thread.
class FootprintPainter {
 public:
  FootprintPainter();
  /// @param tolerance  of the distance from the face's plane [m]
  Footprint paint(const DrawableMesh& mesh, const Eigen::Affine3d& face_from_mesh,
                  const Eigen::Vector2d& size, double tolerance) const;

 private:
  Program program_;
  Framebuffer target_;
};

}  // namespace carillon::render
