#include "solvers/mesh/tetrahedra/detail/size_field.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <unordered_map>

#include "solvers/mesh/sizing.hpp"
#include "solvers/mesh/tetrahedra/detail/feature_lines.hpp"

namespace carillon::solvers::mesh::tetrahedra {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// Edges of one layer of elements over its thickness: at more their dihedral angles fall below 5
/// degrees.
constexpr double max_aspect = 10;

/// Neighbours of every triangle across its edges (v0v1)(v1v2)(v2v0); -1 where there is none.
std::vector<std::array<std::int64_t, 3>> neighbours(const SurfaceMesh& surface) {
  std::unordered_map<std::uint64_t, std::pair<std::size_t, std::size_t>> open;
  std::vector<std::array<std::int64_t, 3>> across(surface.triangles.size(), {-1, -1, -1});
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [low, high] =
          std::minmax({surface.triangles[t][i], surface.triangles[t][(i + 1) % 3]});
      const auto key = (static_cast<std::uint64_t>(low) << 32) | static_cast<std::uint64_t>(high);
      const auto [entry, is_new] = open.try_emplace(key, t, i);
      if (is_new) continue;
      across[t][i] = static_cast<std::int64_t>(entry->second.first);
      across[entry->second.first][entry->second.second] = static_cast<std::int64_t>(t);
    }
  return across;
}

}  // namespace

SizeField measure_sizes(const SurfaceMesh& surface, const SurfaceSearch& search) {
  const std::size_t count = surface.triangles.size();
  const double feature = feature_angle_deg * std::numbers::pi / 180;
  SizeField field;
  field.volume = signed_volume(surface);
  std::vector<Vec3> normal(count);
  for (std::size_t t = 0; t < count; ++t) {
    const auto at = [&](std::size_t i) {
      return surface.vertices[static_cast<std::size_t>(surface.triangles[t][i % 3])];
    };
    const Vec3 twice = (at(1) - at(0)).cross(at(2) - at(0));
    field.area.push_back(twice.norm() / 2);
    field.total_area += field.area.back();
    normal[t] = twice.norm() > 0 ? Vec3(twice.normalized()) : Vec3(Vec3::Zero());
    field.thickness.push_back(search.thickness_below(t));
  }

  // Bending across an edge: the angle between its faces over the mean of their heights on it.
  const auto across = neighbours(surface);
  std::vector<double> curvature(count, 0);
  for (std::size_t t = 0; t < count; ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      if (across[t][i] < 0) continue;
      const auto other = static_cast<std::size_t>(across[t][i]);
      const double angle = angle_between(normal[t], normal[other]);
      field.sharpest_edge = std::min(field.sharpest_edge, std::numbers::pi - angle);
      if (angle > feature) continue;
      const double edge =
          (surface.vertices[static_cast<std::size_t>(surface.triangles[t][i])] -
           surface.vertices[static_cast<std::size_t>(surface.triangles[t][(i + 1) % 3])])
              .norm();
      const double height = (field.area[t] + field.area[other]) / edge;
      if (height > 0) curvature[t] = std::max(curvature[t], angle / height);
    }
  // Scans are noisy from face to face: a few rounds of averaging by area.
  for (int round = 0; round < 3; ++round) {
    std::vector<double> smooth(count);
    for (std::size_t t = 0; t < count; ++t) {
      double weight = field.area[t], sum = field.area[t] * curvature[t];
      for (std::int64_t n : across[t])
        if (n >= 0 && normal[t].dot(normal[static_cast<std::size_t>(n)]) > std::cos(feature)) {
          weight += field.area[static_cast<std::size_t>(n)];
          sum += field.area[static_cast<std::size_t>(n)] * curvature[static_cast<std::size_t>(n)];
        }
      smooth[t] = weight > 0 ? sum / weight : 0;
    }
    curvature = std::move(smooth);
  }
  for (double k : curvature) field.radius.push_back(k > 0 ? 1 / k : infinite);
  return field;
}

std::vector<double> vertex_sizes(const SurfaceMesh& surface, const SizeField& field,
                                 double coarsest, double relax) {
  std::vector<double> sizes(surface.vertices.size(), coarsest);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (std::int32_t v : surface.triangles[t]) {
      auto& size = sizes[static_cast<std::size_t>(v)];
      size = std::min(size, field.edge(t, coarsest, relax));
    }
  limit_growth(surface, sizes);
  return sizes;
}

void limit_growth(const SurfaceMesh& surface, std::vector<double>& sizes) {
  constexpr double growth = 0.5;
  // Dijkstra's walk from the smallest sizes outwards.
  std::vector<std::vector<std::int32_t>> around(sizes.size());
  for (const Triangle& t : surface.triangles)
    for (std::size_t i = 0; i < 3; ++i)
      around[static_cast<std::size_t>(t[i])].push_back(t[(i + 1) % 3]);
  std::set<std::pair<double, std::int32_t>> waiting;
  for (std::size_t v = 0; v < sizes.size(); ++v)
    waiting.emplace(sizes[v], static_cast<std::int32_t>(v));
  while (!waiting.empty()) {
    const auto [size, v] = *waiting.begin();
    waiting.erase(waiting.begin());
    for (std::int32_t n : around[static_cast<std::size_t>(v)]) {
      const auto other = static_cast<std::size_t>(n);
      const double reached =
          size +
          growth * (surface.vertices[other] - surface.vertices[static_cast<std::size_t>(v)]).norm();
      if (reached >= sizes[other]) continue;
      waiting.erase({sizes[other], n});
      sizes[other] = reached;
      waiting.emplace(reached, n);
    }
  }
}

double SizeField::edge(std::size_t triangle, double coarsest, double relax) const {
  const double finest = coarsest / 16;
  const double r = relax * radius[triangle];
  const double bend = std::isfinite(r) ? max_chord(r, thickness[triangle]) : infinite;
  return std::clamp(std::min(bend, max_aspect * thickness[triangle]), finest, coarsest);
}

double SizeField::triangles(double coarsest, double relax) const {
  double sum = 0;
  for (std::size_t t = 0; t < area.size(); ++t) {
    const double size = edge(t, coarsest, relax);
    sum += area[t] / (0.433 * size * size);
  }
  return sum;
}

double SizeField::tetrahedra(double coarsest, double relax) const {
  return 1.5 * triangles(coarsest, relax) + 5 * volume / std::pow(coarsest, 3);
}

}  // namespace carillon::solvers::mesh::tetrahedra
