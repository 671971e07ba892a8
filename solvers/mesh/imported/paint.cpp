#include "solvers/mesh/imported/paint.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "solvers/mesh/tetrahedra/surface_search.hpp"

namespace carillon::solvers::mesh::imported {

namespace {

/// Of an sRGB byte (IEC 61966-2-1).
double linear_light(std::uint8_t byte) {
  const double value = byte / 255.0;
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

Vec3 pixel(const core::Image& image, std::int64_t column, std::int64_t row) {
  const auto wrapped = [](std::int64_t i, std::int64_t size) { return ((i % size) + size) % size; };
  const auto first = static_cast<std::size_t>(
      (wrapped(row, image.height) * image.width + wrapped(column, image.width)) * image.channels);
  const std::size_t step = image.channels >= 3 ? 1 : 0;
  return {linear_light(image.pixels[first]), linear_light(image.pixels[first + step]),
          linear_light(image.pixels[first + 2 * step])};
}

Vec3 picture_at(const core::Image& image, const Eigen::Vector2d& place) {
  const double x = place.x() * image.width - 0.5, y = place.y() * image.height - 0.5;
  if (!(std::abs(x) < 1e9 && std::abs(y) < 1e9)) return Vec3::Ones();
  const auto column = static_cast<std::int64_t>(std::floor(x));
  const auto row = static_cast<std::int64_t>(std::floor(y));
  const double right = x - static_cast<double>(column), down = y - static_cast<double>(row);
  return (1 - down) *
             ((1 - right) * pixel(image, column, row) + right * pixel(image, column + 1, row)) +
         down * ((1 - right) * pixel(image, column, row + 1) +
                 right * pixel(image, column + 1, row + 1));
}

/// Weights of a triangle's corners at a point in it; a third each where it has no area.
Vec3 weights_at(const SurfaceMesh& surface, std::size_t triangle, const Vec3& point) {
  const auto corner = [&](std::size_t i) {
    return surface.vertices[static_cast<std::size_t>(surface.triangles[triangle][i])];
  };
  const Vec3 a = corner(0), b = corner(1), c = corner(2);
  const Vec3 normal = (b - a).cross(c - a);
  const double squared = normal.squaredNorm();
  if (!(squared > 0)) return Vec3::Constant(1.0 / 3);
  const double at_b = normal.dot((point - a).cross(c - a)) / squared;
  const double at_c = normal.dot((b - a).cross(point - a)) / squared;
  return {1 - at_b - at_c, at_b, at_c};
}

}  // namespace

bool Paint::shows() const {
  const auto white = [](const Vec3& colour) { return (colour - Vec3::Ones()).norm() < 1e-3; };
  return std::any_of(faces.begin(), faces.end(), [&](const Face& face) {
    const Coat& coat = coats[face.coat];
    return coat.picture || !white(coat.colour) ||
           !std::all_of(face.colours.begin(), face.colours.end(), white);
  });
}

std::vector<Vec3> colours_at(const SurfaceMesh& surface, const Paint& paint,
                             std::span<const Vec3> points) {
  const tetrahedra::SurfaceSearch search(surface);
  std::vector<Vec3> colours;
  colours.reserve(points.size());
  for (const Vec3& point : points) {
    const auto [place, triangle] = search.nearest(point);
    const Vec3 weights = weights_at(surface, triangle, place);
    const Paint::Face& face = paint.faces[triangle];
    const Paint::Coat& coat = paint.coats[face.coat];
    Vec3 colour = Vec3::Zero();
    Eigen::Vector2d at = Eigen::Vector2d::Zero();
    for (std::size_t i = 0; i < 3; ++i) {
      colour += weights[static_cast<Eigen::Index>(i)] * face.colours[i];
      at += weights[static_cast<Eigen::Index>(i)] * face.places[i];
    }
    colour = colour.cwiseProduct(coat.colour);
    if (coat.picture) colour = colour.cwiseProduct(picture_at(*coat.picture, at));
    colours.push_back(colour.cwiseMax(0).cwiseMin(1));
  }
  return colours;
}

}  // namespace carillon::solvers::mesh::imported
