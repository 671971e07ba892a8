#include "render/detail/scene_checks.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "core/error.hpp"

namespace carillon::render {
namespace {

void check(const SceneCamera& camera) {
  check_picture(camera.width, camera.height, camera.field_of_view);
  if (camera.samples != 1 && camera.samples != 3 && camera.samples != 5) {
    throw core::InputError(
        fmt::format("camera: 1, 3 or 5 samples per pixel and direction, not {}", camera.samples));
  }
  const Vec3 way = camera.target - camera.eye;
  if (!way.allFinite() || !(way.norm() > 0)) {
    throw core::InputError("camera: eye and target must be finite and apart");
  }
  if (!camera.up.allFinite() || !(way.normalized().cross(camera.up.normalized()).norm() > 1e-6)) {
    throw core::InputError("camera: up must not point along the line of sight",
                           "looking straight down, the y axis may be up");
  }
}

void check(const std::optional<Vec3>& color) {
  if (color) looks::check(Appearance{.color = *color});
}

void check(const maps::TexturedFace& face) {
  if (face.map == nullptr) throw core::InputError("a textured face has no map");
  const bool frame = std::abs(face.u.norm() - 1) < 1e-6 && std::abs(face.v.norm() - 1) < 1e-6 &&
                     std::abs(face.u.dot(face.v)) < 1e-6 && face.origin.allFinite();
  if (!frame || !(face.size.array() > 0).all() || !face.size.allFinite()) {
    throw core::InputError(
        fmt::format("map {}: its face needs unit vectors u and v at right angles, and an extent",
                    face.map->name));
  }
}

}  // namespace

void check_picture(int width, int height, double field_of_view) {
  if (width < 1 || height < 1 || width > max_picture_side || height > max_picture_side) {
    throw core::InputError(fmt::format("camera: picture must be 1 to {} pixels a side, not {} x {}",
                                       max_picture_side, width, height));
  }
  if (!(field_of_view > 0 && field_of_view < std::numbers::pi)) {
    throw core::InputError(
        fmt::format("camera: field of view must lie between 0 and pi, not {} rad", field_of_view));
  }
}

void check(const SceneCamera& camera, const Vec3& light) {
  check(camera);
  if (!light.allFinite() || !(light.norm() > 0)) {
    throw core::InputError("light: a direction must be finite and not zero");
  }
}

void check(const Scene& scene) {
  check(scene.camera, scene.light);
  if (!(scene.light_radius >= 0 && scene.light_radius < 0.5)) {
    throw core::InputError(
        fmt::format("light: its angular radius must be 0 to 0.5 rad, not {}", scene.light_radius));
  }
  if (scene.bodies.size() > 255) {
    throw core::InputError(
        fmt::format("a scene of {} bodies: masks can tell 255 apart", scene.bodies.size()));
  }
  for (const SceneBody& body : scene.bodies) {
    looks::check(body.appearance);
    check(body.deep_color);
    if (body.texture) check(*body.texture);
  }
  if (!scene.ground) return;
  looks::check(scene.ground->appearance);
  check(scene.ground->deep_color);
  if (!(scene.ground->reach > 0) || !std::isfinite(scene.ground->reach) ||
      !scene.ground->middle.allFinite()) {
    throw core::InputError("ground: its reach must be positive and its middle finite");
  }
}

void check_poses(std::span<const ScenePose> poses, std::size_t bodies) {
  if (poses.size() != bodies) {
    throw core::InputError(fmt::format("{} poses for {} bodies", poses.size(), bodies));
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!poses[i].origin.allFinite() || !poses[i].turn.coeffs().allFinite() ||
        !(poses[i].turn.norm() > 0)) {
      throw core::InputError(fmt::format("the pose of body {} is not finite", i + 1));
    }
  }
}

}  // namespace carillon::render
