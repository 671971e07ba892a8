#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <map>

#include "solvers/families/family.hpp"
#include "solvers/mesh/curve_mesh.hpp"
#include "solvers/mesh/sizing.hpp"
#include "solvers/mesh/tetrahedra/delaunay.hpp"

namespace carillon::solvers::families {
namespace {

/// Sphere about the origin: the icosahedron with each face cut into frequency^2 triangles.
mesh::SurfaceMesh geodesic_sphere(double radius, int frequency) {
  const double golden = 0.5 * (1 + std::sqrt(5.0));
  std::vector<Vec3> corners;
  for (double a : {-1.0, 1.0})
    for (double b : {-golden, golden})
      for (Eigen::Index k = 0; k < 3; ++k) {
        Vec3 p = Vec3::Zero();
        p[k] = a;
        p[(k + 1) % 3] = b;
        corners.push_back(p);
      }
  // Faces are the triples at the shortest distance, 2, from each other.
  const auto close = [&](std::size_t i, std::size_t j) {
    return std::abs((corners[i] - corners[j]).norm() - 2) < 1e-9;
  };
  mesh::SurfaceMesh mesh;
  std::map<std::array<int, 6>, std::int32_t> known;
  for (std::size_t i = 0; i < 12; ++i)
    for (std::size_t j = i + 1; j < 12; ++j)
      for (std::size_t k = j + 1; k < 12; ++k) {
        if (!close(i, j) || !close(j, k) || !close(k, i)) continue;
        std::array<std::size_t, 3> face{i, j, k};
        if ((corners[j] - corners[i]).cross(corners[k] - corners[i]).dot(corners[i]) < 0)
          std::swap(face[1], face[2]);
        const auto vertex = [&](int u, int v) {
          // Corners sorted by number with their weights: the same key from every face.
          std::map<int, int> weights;
          const std::array<int, 3> weight{frequency - u - v, u, v};
          Vec3 p = Vec3::Zero();
          for (std::size_t c = 0; c < 3; ++c)
            if (weight[c] > 0) weights[static_cast<int>(face[c])] = weight[c];
          std::array<int, 6> key{-1, -1, -1, -1, -1, -1};
          std::size_t at = 0;
          for (const auto& [corner, fraction] : weights) {
            key[at++] = corner;
            key[at++] = fraction;
            p += fraction * corners[static_cast<std::size_t>(corner)];
          }
          const auto [entry, is_new] =
              known.try_emplace(key, static_cast<std::int32_t>(mesh.vertices.size()));
          if (is_new) mesh.vertices.push_back(radius * p.normalized());
          return entry->second;
        };
        for (int u = 0; u < frequency; ++u)
          for (int v = 0; u + v < frequency; ++v) {
            mesh.triangles.push_back({vertex(u, v), vertex(u + 1, v), vertex(u, v + 1)});
            if (u + v + 1 < frequency)
              mesh.triangles.push_back({vertex(u + 1, v), vertex(u + 1, v + 1), vertex(u, v + 1)});
          }
      }
  return mesh;
}

/// Cells along an icosahedron's edge, which spans 63.4 degrees of the sphere; its longest chords
/// are about a sixth above the mean.
int frequency_for(double radius, double edge) {
  return std::max(2, static_cast<int>(std::ceil(1.25 * radius / edge * (1 - 1e-9))));
}

}  // namespace

mesh::MeshResult mesh_sphere(const mesh::GeneratedShape& shape, const mesh::MeshOptions& options) {
  check_parameters(shape);
  const double radius = parameter(shape, "radius");
  // Measured: a ball holds about 12 f^3 tetrahedra behind its 20 f^2 triangles.
  const auto count = [&](double cell) {
    const std::int64_t f = frequency_for(radius, cell);
    return 12 * f * f * f;
  };
  mesh::MeshOptions isotropic = options;
  isotropic.element_size *= std::sqrt(3.0);  // edges, where cell_size() thinks of diagonals
  const double cell = mesh::cell_size(isotropic, 2 * radius, 2 * radius, count);
  const mesh::TetMesh linear =
      mesh::tetrahedra::fill_with_tetrahedra(geodesic_sphere(radius, frequency_for(radius, cell)));
  std::int64_t straightened = 0;
  mesh::TetMesh mesh = mesh::curve_mesh(
      linear, options.order,
      {[radius](const Vec3& p, const Vec3&) -> Vec3 { return radius * p.normalized(); }, {}},
      straightened);
  return finish(std::move(mesh), straightened);
}

/// A ball of the same volume, drawn out along the axes.
mesh::MeshResult mesh_pebble(const mesh::GeneratedShape& shape, const mesh::MeshOptions& options) {
  check_parameters(shape);
  const Vec3 half =
      Vec3(parameter(shape, "length"), parameter(shape, "width"), parameter(shape, "height")) / 2;
  const double radius = std::cbrt(half.prod());
  mesh::MeshOptions of_ball = options;
  of_ball.element_size *= radius / half.maxCoeff();
  mesh::MeshResult ball = mesh_sphere({"sphere", {{"radius", radius}}, {}}, of_ball);
  const Vec3 stretch = half / radius;
  for (auto* nodes : {&ball.mesh.nodes, &ball.mesh.finer_nodes, &ball.mesh.finer_gaps})
    for (Vec3& node : *nodes) node = node.cwiseProduct(stretch);
  return finish(std::move(ball.mesh), ball.quality.straightened);
}

}  // namespace carillon::solvers::families
