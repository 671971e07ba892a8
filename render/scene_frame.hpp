#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/image.hpp"
#include "render/frame.hpp"
#include "render/maps/surface_map.hpp"

namespace carillon::render {

/// A camera that stays where it is.
struct SceneCamera {
  int width = 256;  ///< [pixel]
  int height = 256;
  Vec3 eye = {0.4, -0.6, 0.4};  ///< world [m]
  Vec3 target = Vec3::Zero();   ///< in the middle of the picture
  Vec3 up = Vec3::UnitZ();
  double field_of_view = 0.6;  ///< vertical [rad]
  int samples = 3;             ///< of colour per pixel and direction: 1, 3 or 5
};

struct SceneBody {
  solvers::mesh::SurfaceMesh mesh;  ///< body's coordinates [m]
  Appearance appearance;
  /// Detail of a flat side of the body, in the body's coordinates. A normal map changes its
  /// shading; a relief is cut into it: rays march through it to where they meet it, also at the
  /// side's edges, and to the light. The side need not be a rectangle, nor end where the map does.
  std::optional<maps::TexturedFace> texture;
  /// Colour of the deepest parts of a relief (mortar, the earth between pebbles): it takes over
  /// between a quarter and three quarters of the depth.
  std::optional<Vec3> deep_color;
  FaceLooks faces = {};  ///< faces of other materials
};

/// A square of level ground about a place, facing up. It is no body: the mask has it as background.
struct SceneGround {
  Vec3 middle = Vec3::Zero();  ///< [m]
  double reach = 10;           ///< from the middle to its edges, where it fades away [m]
  Appearance appearance = {{0.32, 0.31, 0.30}, 0.8, 0};
  std::shared_ptr<const maps::SurfaceMap> map;  ///< lower left corner at the ground's; u along x
  std::optional<Vec3> deep_color;
};

/// What does not change while a scene moves.
struct Scene {
  std::vector<SceneBody> bodies;  ///< at most 255
  std::optional<SceneGround> ground;
  SceneCamera camera;
  Vec3 light = {-0.7, -0.15, 0.7};  ///< towards the key light, which is far away
  double light_radius = 0.08;       ///< angular, of its disc [rad], below 0.5; 0: sharp shadows
};

/// Where a body's coordinates are.
struct ScenePose {
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  Vec3 origin = Vec3::Zero();  ///< [m]
};

/// Rows from top to bottom. Depth and mask are of the middle of each pixel.
struct SceneFrame {
  core::Image color;               ///< sRGB
  std::vector<float> depth;        ///< along the camera's axis [m]; infinite where nothing is
  std::vector<std::uint8_t> mask;  ///< 0 background and ground, i + 1 body i
};

/// Draws frames of one scene, off screen; meshes, maps and programs stay with OpenGL.
/// Draws, and ends, in the thread that made it. The same scene and poses give the same bytes.
class SceneRenderer {
 public:
  /// @throws InputError   no faces or extent, a camera, light, appearance or map that cannot be
  /// @throws core::Error  no OpenGL 3.3 context can be made
  explicit SceneRenderer(const Scene& scene);
  ~SceneRenderer();
  SceneRenderer(SceneRenderer&&) noexcept;

  /// From another place, by another key light, from now on.
  /// @throws InputError  a camera or light that cannot be
  void look_from(const SceneCamera& camera, const Vec3& light);
  /// @param poses  one for each body
  /// @throws InputError  another number of poses, or one that is not finite
  SceneFrame draw(std::span<const ScenePose> poses);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace carillon::render
