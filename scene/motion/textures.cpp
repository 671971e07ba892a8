#include "scene/motion/textures.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.hpp"
#include "render/maps/generated_maps.hpp"
#include "render/maps/map_image.hpp"

namespace carillon::scene::motion {

std::shared_ptr<const render::maps::SurfaceMap> Textures::of(const TextureConfig& texture) {
  std::string key = texture.map + texture.image;
  for (const auto& [name, value] : texture.parameters) key += fmt::format(" {} {}", name, value);
  key += fmt::format(" {} {} {} {} {} {}", texture.texels, texture.options.width,
                     texture.options.depth, texture.options.repeats, texture.options.green_down,
                     texture.normals);
  const auto found = maps_.find(key);
  if (found != maps_.end()) return found->second;
  render::maps::SurfaceMap map =
      texture.map.empty()
          ? render::maps::read_map(texture.image, texture.options)
          : render::maps::generate_map(texture.map, texture.parameters, texture.texels, seed_);
  if (texture.normals && map.relief()) map = render::maps::normal_map_of(map);
  return maps_[key] = std::make_shared<const render::maps::SurfaceMap>(std::move(map));
}

namespace {

/// Least part of a side's rectangle that is flat: a disc's is 0.79, a ball's 0.
constexpr double min_flat = 0.25;

/// Part of the face's rectangle that the body's flat side takes.
double flat_part(const render::maps::TexturedFace& face,
                 const solvers::mesh::SurfaceMesh& surface) {
  const double near = 1e-6 * face.size.norm();
  double area = 0;
  for (const solvers::mesh::Triangle& triangle : surface.triangles) {
    std::array<Vec3, 3> p;
    bool within = true;
    for (std::size_t k = 0; k < 3; ++k) {
      p[k] = surface.vertices[static_cast<std::size_t>(triangle[k])] - face.origin;
      within = within && std::abs(p[k].dot(face.normal())) <= near;
    }
    if (within) area += 0.5 * (p[1] - p[0]).cross(p[2] - p[0]).norm();
  }
  return area / face.size.prod();
}

std::string side_of(const TextureConfig& texture) {
  return fmt::format("{}{}", texture.towards_plus ? '+' : '-', texture.axis);
}

/// A strike pushes a body out of another by the shorter way: through a relief that is deep it would
/// be the wrong one.
void check_face(const TextureConfig& texture, const render::maps::TexturedFace& face,
                double thickness, const solvers::mesh::SurfaceMesh* surface) {
  const double flat = surface != nullptr ? flat_part(face, *surface) : 1;
  if (flat < min_flat) {
    throw core::InputError(
        fmt::format("its side {} is not flat ({:.0f} % of the rectangle around it): a texture "
                    "needs a plane",
                    side_of(texture), 100 * flat),
        "choose another `face:`, or a body with a flat side");
  }
  if (!face.map->relief()) return;
  const double depth =
      -static_cast<double>(*std::min_element(face.map->heights.begin(), face.map->heights.end()));
  if (depth < thickness / 2) return;
  throw core::InputError(
      fmt::format("its relief is {:.3g} mm deep, the body {:.3g} mm thick below its side {}",
                  1e3 * depth, 1e3 * thickness, side_of(texture)),
      "a relief must be less than half as deep: take a thicker body, or another depth");
}

}  // namespace

render::maps::TexturedFace Textures::on(const TextureConfig& texture, const solvers::mesh::Box& box,
                                        const solvers::mesh::SurfaceMesh* surface) {
  const Eigen::Index normal = texture.axis - 'x';
  // u and v such that u x v looks outward.
  Eigen::Index u = (normal + 1) % 3, v = (normal + 2) % 3;
  if (!texture.towards_plus) std::swap(u, v);
  render::maps::TexturedFace face;
  face.map = of(texture);
  face.u = Vec3::Unit(u);
  face.v = Vec3::Unit(v);
  face.origin = box.low;
  face.origin[normal] = texture.towards_plus ? box.high[normal] : box.low[normal];
  const Vec3 sides = box.high - box.low;
  face.size = {sides[u], sides[v]};
  check_face(texture, face, sides[normal], surface);
  return face;
}

}  // namespace carillon::scene::motion
