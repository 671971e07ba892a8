#include "solvers/families/extrude.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

#include "solvers/mesh/raise_order.hpp"

namespace carillon::solvers::families {
namespace {

/// Corner of a swept tetrahedron: which corner of its triangle, on which level.
struct SweptCorner {
  int corner;
  int level;  ///< 0 bottom, 1 top of the layer
};
using SweptTetrahedron = std::array<SweptCorner, 4>;

/// The three tetrahedra of a prism over a triangle with ascending vertices a < b < c. Vertices
/// are numbered level by level, so every side is cut from its lower bottom vertex.
constexpr std::array<SweptTetrahedron, 3> prism = {{{{{0, 0}, {1, 0}, {2, 0}, {2, 1}}},
                                                    {{{0, 0}, {1, 0}, {1, 1}, {2, 1}}},
                                                    {{{0, 0}, {0, 1}, {1, 1}, {2, 1}}}}};

/// Whether a map turns space over, from differences about one point.
double map_orientation(const std::function<Vec3(const Vec2&, double)>& map, const Vec2& at,
                       double step) {
  const Vec3 dx = map(at + Vec2(step, 0), 0.5) - map(at - Vec2(step, 0), 0.5);
  const Vec3 dy = map(at + Vec2(0, step), 0.5) - map(at - Vec2(0, step), 0.5);
  const Vec3 dt = map(at, 0.75) - map(at, 0.25);
  return dx.cross(dy).dot(dt) > 0 ? 1.0 : -1.0;
}

/// What a swept tetrahedron came from.
struct Origin {
  std::size_t triangle;
  int layer;
  SweptTetrahedron corners;
};

}  // namespace

mesh::TetMesh extrude(const PlanarGrid& grid, int layers, int order,
                      const std::function<Vec3(const Vec2&, double)>& map, bool closed) {
  const int levels = closed ? layers : layers + 1;
  const auto plane = [&](std::size_t triangle, int corner) {
    return grid.point(triangle, Eigen::Vector3d::Unit(corner));
  };
  double span = 0;
  for (int i = 1; i < 3; ++i) span = std::max(span, (plane(0, i) - plane(0, 0)).norm());
  const Vec2 middle = grid.point(0, Eigen::Vector3d::Constant(1.0 / 3));
  const double orientation = map_orientation(map, middle, 0.01 * span);

  std::vector<elements::Corners> tetrahedra;
  std::vector<Origin> origins;
  for (int layer = 0; layer < layers; ++layer)
    for (std::size_t t = 0; t < grid.triangles.size(); ++t) {
      std::array<int, 3> ascending{0, 1, 2};
      const auto& vertices = grid.triangles[t];
      std::sort(ascending.begin(), ascending.end(), [&](int i, int j) {
        return vertices[static_cast<std::size_t>(i)] < vertices[static_cast<std::size_t>(j)];
      });
      for (SweptTetrahedron swept : prism) {
        for (auto& c : swept) c.corner = ascending[static_cast<std::size_t>(c.corner)];
        std::array<Vec3, 4> p;
        for (std::size_t i = 0; i < 4; ++i) {
          p[i].head<2>() = plane(t, swept[i].corner);
          p[i].z() = swept[i].level;
        }
        if (mesh::six_volumes(p[0], p[1], p[2], p[3]) * orientation < 0)
          std::swap(swept[2], swept[3]);
        elements::Corners corners;
        for (std::size_t i = 0; i < 4; ++i)
          corners[i] = (layer + swept[i].level) % levels * grid.vertices +
                       vertices[static_cast<std::size_t>(swept[i].corner)];
        tetrahedra.push_back(corners);
        origins.push_back({t, layer, swept});
      }
    }

  const auto numbering = elements::number_nodes(tetrahedra, grid.vertices * levels, order);
  // Nodes of an order where a numbering met them first.
  const auto points = [&](const elements::NodeNumbering& numbers, int at_order) {
    const auto& lattice = elements::tetrahedron_lattice(at_order);
    std::vector<Vec3> nodes;
    nodes.reserve(numbers.first_use.size());
    for (std::int64_t use : numbers.first_use) {
      const auto& origin = origins[static_cast<std::size_t>(use) / lattice.size()];
      const auto& weights = lattice[static_cast<std::size_t>(use) % lattice.size()];
      Eigen::Vector3i barycentric = Eigen::Vector3i::Zero();
      int level = 0;  // in units of 1 / order, exact on both faces
      for (std::size_t i = 0; i < 4; ++i) {
        barycentric[origin.corners[i].corner] += weights[i];
        level += weights[i] * origin.corners[i].level;
      }
      const double t = static_cast<double>(origin.layer * at_order + level) /
                       static_cast<double>(layers * at_order);
      nodes.push_back(map(grid.point(origin.triangle, barycentric.cast<double>() / at_order), t));
    }
    return nodes;
  };
  mesh::TetMesh mesh;
  mesh.order = order;
  mesh.elements = numbering.elements;
  mesh.regions.assign(tetrahedra.size(), 0);
  mesh.region_names = {"body"};
  mesh.nodes = points(numbering, order);
  mesh.finer_nodes = points(mesh::numbering_at(mesh, order + 1), order + 1);
  mesh.faces = mesh::boundary_faces(mesh);
  return mesh;
}

}  // namespace carillon::solvers::families
