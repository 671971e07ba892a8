#include "render/detail/studio.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace carillon::render {
namespace {

/// A box in a direction, upright where that is not straight up or down.
SoftBox box_at(const Vec3& direction, const Eigen::Vector2d& half, const Vec3& light) {
  const bool upright = std::abs(direction.z()) < 0.999;
  const Vec3 side = (upright ? Vec3::UnitZ() : Vec3::UnitX()).cross(direction).normalized();
  SoftBox box;
  box.axes << side, direction.cross(side), direction;
  box.half = half;
  box.light = light;
  return box;
}

/// At an azimuth from `forward` and an elevation [rad].
Vec3 direction_at(const Vec3& forward, double azimuth, double elevation) {
  const Vec3 turned = Eigen::AngleAxisd(azimuth, Vec3::UnitZ()) * forward;
  return std::cos(elevation) * turned + std::sin(elevation) * Vec3::UnitZ();
}

}  // namespace

Vec3 SoftBox::radiance() const {
  const double w = half.x(), h = half.y();
  const double solid_angle = 4 * std::atan(w * h / std::sqrt(1 + w * w + h * h));
  return std::numbers::pi / solid_angle * light;
}

Vec3 Studio::on_the_floor() const {
  Vec3 sum = sky;
  for (const SoftBox& box : boxes) sum += std::max(box.axes(2, 2), 0.0) * box.light;
  return sum;
}

Studio make_studio(const Vec3& key, double radius, const Vec3& ground) {
  Vec3 forward(key.x(), key.y(), 0);
  forward = forward.norm() > 1e-6 ? Vec3(forward.normalized()) : Vec3(Vec3::UnitX());
  // A square of the lamp's area.
  const double side = std::max(std::tan(radius), 1e-3) * std::sqrt(std::numbers::pi) / 2;
  Studio studio{{0.30, 0.31, 0.33},
                Vec3::Zero(),
                {box_at(key, {side, side}, {0.76, 0.74, 0.70}),
                 box_at(direction_at(forward, 2.1, 0.35), {0.35, 0.6}, {0.05, 0.055, 0.065}),
                 box_at(direction_at(forward, -2.6, 0.6), {0.7, 0.16}, {0.06, 0.06, 0.063})}};
  // Objects stand on the floor and shade it.
  studio.floor = 0.7 * ground.cwiseProduct(studio.on_the_floor());
  return studio;
}

void set_studio(const Program& program, const Studio& studio) {
  set_vector(program, "sky_light", studio.sky);
  set_vector(program, "floor_light", studio.floor);
  for (std::size_t i = 0; i < studio.boxes.size(); ++i) {
    const SoftBox& box = studio.boxes[i];
    const Eigen::Matrix3f axes = box.axes.cast<float>();
    const auto at = [&](const char* name) {
      return glGetUniformLocation(program.get(), fmt::format("{}[{}]", name, i).c_str());
    };
    glUniformMatrix3fv(at("box_axes"), 1, GL_FALSE, axes.data());
    glUniform2f(at("box_half"), float(box.half.x()), float(box.half.y()));
    set_vector(program, fmt::format("box_light[{}]", i), box.light);
    set_vector(program, fmt::format("box_radiance[{}]", i), box.radiance());
  }
}

}  // namespace carillon::render
