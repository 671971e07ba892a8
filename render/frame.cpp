#include "render/frame.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/error.hpp"
#include "render/scene_frame.hpp"
#include "render/shading_mesh.hpp"

namespace carillon::render {

namespace {

constexpr int samples = 3;            ///< per pixel and direction
constexpr double room_around = 1.08;  ///< room around the body's ball

/// Towards the key light, which stays with the camera: to the right, up and towards the camera.
const Vec3 key_light(-0.55, 0.75, 0.65);

void check_camera(const Camera& camera) {
  check_picture(camera.width, camera.height, camera.field_of_view);
  if (!std::isfinite(camera.azimuth) || !std::isfinite(camera.elevation)) {
    throw core::InputError("camera: azimuth and elevation must be finite");
  }
  if (!(camera.distance >= 0) || !std::isfinite(camera.distance)) {
    throw core::InputError(
        fmt::format("camera: distance must not be negative, not {} m", camera.distance));
  }
}

/// A camera about a body whose ball's centre is the origin.
struct View {
  SceneCamera camera;
  Vec3 light;
};

View view_of(const Camera& camera, double radius) {
  const double az = camera.azimuth, el = camera.elevation;
  const Vec3 back(std::cos(el) * std::cos(az), std::cos(el) * std::sin(az), std::sin(el));
  const Vec3 right(-std::sin(az), std::cos(az), 0);
  const Vec3 up = back.cross(right);
  const double half_height = std::tan(camera.field_of_view / 2);
  const double aspect = static_cast<double>(camera.width) / camera.height;
  const double half_narrow = std::atan(half_height * std::min(1.0, aspect));
  const double distance =
      camera.distance > 0 ? camera.distance : radius * room_around / std::sin(half_narrow);
  return {{.width = camera.width,
           .height = camera.height,
           .eye = distance * back,
           .target = Vec3::Zero(),
           .up = up,
           .field_of_view = camera.field_of_view,
           .samples = samples},
          key_light.x() * right + key_light.y() * up + key_light.z() * back};
}

}  // namespace

std::vector<core::Image> render_frames(const solvers::mesh::SurfaceMesh& mesh,
                                       std::span<const Camera> cameras,
                                       const Appearance& appearance, const FaceLooks& faces) {
  for (const Camera& camera : cameras) check_camera(camera);
  if (cameras.empty()) return {};
  const BoundingBall ball = bounding_ball(mesh);
  const View first = view_of(cameras.front(), ball.radius);
  Scene scene;
  scene.bodies.push_back({mesh, appearance, {}, {}, faces});
  scene.camera = first.camera;
  scene.light = first.light;
  SceneRenderer renderer(scene);
  const ScenePose pose{.origin = -ball.centre};
  std::vector<core::Image> images;
  for (const Camera& camera : cameras) {
    const View view = view_of(camera, ball.radius);
    renderer.look_from(view.camera, view.light);
    images.push_back(renderer.draw({&pose, 1}).color);
  }
  return images;
}

core::Image render_frame(const solvers::mesh::SurfaceMesh& mesh, const Camera& camera,
                         const Appearance& appearance, const FaceLooks& faces) {
  return render_frames(mesh, {&camera, 1}, appearance, faces).front();
}

}  // namespace carillon::render
