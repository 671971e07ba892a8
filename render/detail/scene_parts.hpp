#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "render/detail/drawing.hpp"
#include "render/detail/face_detail.hpp"
#include "render/detail/footprint.hpp"
#include "render/scene_frame.hpp"

namespace carillon::render {

/// A body, or the ground, with OpenGL.
struct Drawn {
  DrawableMesh mesh;
  BoundingBall ball;
  struct Look {
    Appearance appearance;
    GrainPlace grain;
  };
  std::vector<Look> looks;  ///< of the mesh's parts
  Vec3 deep_color;
  int number = 0;            ///< in the mask
  double fade_distance = 0;  ///< 0: none
  std::optional<FaceDetail> detail;
  std::optional<Footprint> footprint;  ///< of a relief
  Eigen::Affine3d body_from_face = Eigen::Affine3d::Identity();
  Eigen::Vector2d face_size = {0, 0};
  Eigen::Affine3d body_from_mesh = Eigen::Affine3d::Identity();

  /// The most that a part of it lets through.
  double transmission() const;
  double tolerance() const { return 1e-5 * ball.radius; }  ///< of what lies in the face [m]
};

Drawn make_drawn(const SceneBody& body, int number, const FootprintPainter& footprints);
Drawn make_drawn(const SceneGround& ground, const FootprintPainter& footprints);

/// The camera, and how it projects.
struct SceneView {
  Vec3 eye, forward;
  Eigen::Matrix4d clip_from_world;
  double pixel_angle = 0;  ///< [rad]
};
/// @param reach  how far from the camera there is anything to see [m]
SceneView scene_view(const SceneCamera& camera, double reach);

}  // namespace carillon::render
