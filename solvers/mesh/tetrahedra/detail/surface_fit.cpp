#include "solvers/mesh/tetrahedra/detail/surface_fit.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>

#include "solvers/mesh/face_sampler.hpp"
#include "solvers/mesh/spread_points.hpp"

namespace carillon::solvers::mesh::tetrahedra {
namespace {

/// About how many points of either boundary are looked up in the other.
constexpr std::size_t samples = 4000;

/// The curved boundary, each face cut into triangles between neighbouring nodes.
SurfaceMesh through_nodes(const TetMesh& mesh) {
  const auto& lattice = elements::triangle_lattice(mesh.order);
  std::map<std::array<int, 3>, std::size_t> local;
  for (std::size_t n = 0; n < lattice.size(); ++n) local[lattice[n]] = n;
  std::vector<std::array<std::size_t, 3>> pieces;
  const auto at = [&](int i, int j) { return local.at({mesh.order - i - j, i, j}); };
  for (int i = 0; i < mesh.order; ++i)
    for (int j = 0; i + j < mesh.order; ++j) {
      pieces.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      if (i + j + 1 < mesh.order) pieces.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  SurfaceMesh surface{mesh.nodes, {}};
  for (std::size_t f = 0; f < mesh.face_count(); ++f)
    for (const auto& piece : pieces) {
      Triangle triangle;
      for (std::size_t k = 0; k < 3; ++k) triangle[k] = mesh.faces[f * lattice.size() + piece[k]];
      surface.triangles.push_back(triangle);
    }
  return surface;
}

/// Vertices of the triangles, some of them where they are many, and points spread over the area.
std::vector<Vec3> points_on(const SurfaceMesh& surface) {
  std::vector<Vec3> points;
  const std::size_t corners = 3 * surface.triangles.size();
  const std::size_t stride = std::max<std::size_t>(1, corners / samples);
  const auto vertex = [&](std::int32_t v) { return surface.vertices[static_cast<std::size_t>(v)]; };
  for (std::size_t c = 0; c < corners; c += stride)
    points.push_back(vertex(surface.triangles[c / 3][c % 3]));
  for (const SpreadPoint& point : spread_points(surface, samples)) points.push_back(point.at);
  return points;
}

double curved_area(const TetMesh& mesh) {
  const FaceSampler sampler(mesh.order, mesh.order + 1);
  double sum = 0;
  for (std::size_t f = 0; f < mesh.face_count(); ++f)
    for (const FaceSample& sample : sampler.of(mesh, f)) sum += sample.area.norm();
  return sum;
}

double farthest(const std::vector<Vec3>& points, const SurfaceSearch& from) {
  double distance = 0;
  for (const Vec3& p : points) distance = std::max(distance, (from.nearest(p).point - p).norm());
  return distance;
}

}  // namespace

void measure_fit(const TetMesh& mesh, const SurfaceMesh& surface, const SurfaceSearch& search,
                 MeshQuality& quality) {
  const SurfaceMesh made = through_nodes(mesh);
  quality.volume_error = quality.volume / signed_volume(surface) - 1;
  quality.area_error = curved_area(mesh) / area(surface) - 1;
  quality.hausdorff = std::max(farthest(points_on(made), search),
                               farthest(points_on(surface), SurfaceSearch(made)));
}

}  // namespace carillon::solvers::mesh::tetrahedra
