#include "render/detail/scene_parts.hpp"

#include <algorithm>
#include <cmath>

namespace carillon::render {

double Drawn::transmission() const {
  double most = 0;
  for (const Look& look : looks)
    most = std::max(most, look.appearance.transmission * (1 - look.appearance.metallic));
  return most;
}

Drawn make_drawn(const SceneBody& body, int number, const FootprintPainter& footprints) {
  const BoundingBall ball = bounding_ball(body.mesh);
  check_looks(body.appearance, body.faces, body.mesh);
  const ShadingMesh mesh = shading_mesh(body.mesh, ball, default_crease_angle);
  std::vector<Drawn::Look> looks = {
      {body.appearance, grain_place(mesh, ball.radius, body.appearance)}};
  for (const Appearance& other : body.faces.others)
    looks.push_back({other, grain_place(mesh, ball.radius, other)});
  Drawn drawn{.mesh = DrawableMesh(mesh, body.appearance.colours, body.faces.of_faces),
              .ball = ball,
              .looks = std::move(looks),
              .deep_color = body.deep_color.value_or(body.appearance.color),
              .number = number,
              .detail = {},
              .footprint = {}};
  drawn.body_from_mesh.translate(ball.centre).scale(ball.radius);
  if (body.texture) {
    drawn.detail = face_detail(*body.texture->map);
    drawn.body_from_face = body_from_face(*body.texture);
    drawn.face_size = body.texture->size;
    if (drawn.detail->relief()) {
      drawn.footprint =
          footprints.paint(drawn.mesh, drawn.body_from_face.inverse() * drawn.body_from_mesh,
                           drawn.face_size, drawn.tolerance());
    }
  }
  return drawn;
}

Drawn make_drawn(const SceneGround& ground, const FootprintPainter& footprints) {
  const double side = 2 * ground.reach;
  SceneBody body{
      .mesh = {}, .appearance = ground.appearance, .texture = {}, .deep_color = ground.deep_color};
  const Vec3 corner = ground.middle - Vec3(ground.reach, ground.reach, 0);
  for (int i = 0; i < 4; ++i) {
    body.mesh.vertices.push_back(corner + Vec3(i % 2 * side, i / 2 * side, 0));
  }
  body.mesh.triangles = {{0, 1, 3}, {0, 3, 2}};
  if (ground.map) {
    body.texture = {ground.map, corner, Vec3::UnitX(), Vec3::UnitY(), {side, side}};
  }
  Drawn drawn = make_drawn(body, 0, footprints);
  drawn.fade_distance = ground.reach;
  // Wood is a floor of boards, 12 cm wide.
  if (ground.appearance.grain == looks::Grain::wood) drawn.looks.front().grain.plank_width = 4;
  return drawn;
}

SceneView scene_view(const SceneCamera& camera, double reach) {
  SceneView view;
  view.eye = camera.eye;
  const double distance = (camera.target - camera.eye).norm();
  view.forward = (camera.target - camera.eye) / distance;
  const Vec3 right = view.forward.cross(camera.up).normalized();
  const double half = std::tan(camera.field_of_view / 2);
  view.pixel_angle = 2 * half / camera.height;
  const double near = 0.01 * distance, far = 4 * (distance + reach);
  Eigen::Matrix4d projection = Eigen::Matrix4d::Zero();
  projection(0, 0) = camera.height / (half * camera.width);
  projection(1, 1) = 1 / half;
  projection(2, 2) = -(far + near) / (far - near);
  projection(2, 3) = -2 * far * near / (far - near);
  projection(3, 2) = -1;
  Eigen::Matrix4d camera_from_world = Eigen::Matrix4d::Identity();
  camera_from_world.block<1, 3>(0, 0) = right.transpose();
  camera_from_world.block<1, 3>(1, 0) = right.cross(view.forward).transpose();
  camera_from_world.block<1, 3>(2, 0) = -view.forward.transpose();
  camera_from_world.block<3, 1>(0, 3) = -camera_from_world.topLeftCorner<3, 3>() * view.eye;
  view.clip_from_world = projection * camera_from_world;
  return view;
}

}  // namespace carillon::render
