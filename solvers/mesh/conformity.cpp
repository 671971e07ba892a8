#include "solvers/mesh/conformity.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <vector>

#include "core/error.hpp"

namespace carillon::solvers::mesh {
namespace {

struct Face {
  std::array<std::int32_t, 3> key;      ///< corners, ascending
  std::array<std::int32_t, 3> corners;  ///< counter-clockwise from outside the element
  std::size_t element;
  bool even;  ///< the corners are an even permutation of the key
};

Vec3 position(const TetMesh& mesh, std::int32_t node) {
  return mesh.nodes[static_cast<std::size_t>(node)];
}

/// Faces of all elements that are not inside out; those of one place beside each other.
std::vector<Face> sorted_faces(const TetMesh& mesh) {
  // Counter-clockwise from outside.
  constexpr std::array<std::array<std::size_t, 3>, 4> local = {
      {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
  std::vector<Face> faces;
  faces.reserve(4 * mesh.element_count());
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto element = mesh.element(e);
    if (!(six_volumes(mesh, e) > 0)) continue;
    for (const auto& at : local) {
      Face face;
      for (std::size_t i = 0; i < 3; ++i) face.corners[i] = element[at[i]];
      const auto& c = face.corners;
      face.even = ((c[0] > c[1]) + (c[0] > c[2]) + (c[1] > c[2])) % 2 == 0;
      face.key = c;
      std::sort(face.key.begin(), face.key.end());
      face.element = e;
      faces.push_back(face);
    }
  }
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
    return a.key != b.key ? a.key < b.key : a.element < b.element;
  });
  return faces;
}

[[noreturn]] void refuse(const TetMesh& mesh, const Face& first, const Face& second) {
  const Vec3 at =
      (position(mesh, first.key[0]) + position(mesh, first.key[1]) + position(mesh, first.key[2])) /
      3;
  throw core::SolverError(
      fmt::format(
          "elements {} and {} overlap near ({:.4g}, {:.4g}, {:.4g}) m: they lie on the same "
          "side of a face",
          first.element, second.element, at[0], at[1], at[2]),
      "remove elements that stand twice, and untangle those that are folded over others");
}

/// Points in cubes of one size, found by the boxes around them.
class PointGrid {
 public:
  PointGrid(const TetMesh& mesh, const std::vector<std::int32_t>& nodes, double cell)
      : cell_(cell), nodes_(nodes) {
    for (const auto n : nodes) cells_[key(index(position(mesh, n)))].push_back(n);
  }

  template <class Visit>
  void visit(const Vec3& low, const Vec3& high, const Visit& visit_node) const {
    const auto from = index(low), to = index(high);
    double cubes = 1;
    for (std::size_t a = 0; a < 3; ++a) {
      cubes *= static_cast<double>(to[a]) - static_cast<double>(from[a]) + 1;
    }
    // A box that is large beside the others' takes in most points.
    if (cubes > static_cast<double>(nodes_.size())) {
      for (const auto n : nodes_) visit_node(n);
      return;
    }
    for (auto i = from[0]; i <= to[0]; ++i)
      for (auto j = from[1]; j <= to[1]; ++j)
        for (auto k = from[2]; k <= to[2]; ++k) {
          const auto found = cells_.find(key({i, j, k}));
          if (found == cells_.end()) continue;
          for (const auto n : found->second) visit_node(n);
        }
  }

 private:
  using Index = std::array<std::int64_t, 3>;
  Index index(const Vec3& x) const {
    Index at;
    for (int a = 0; a < 3; ++a) {
      at[static_cast<std::size_t>(a)] =
          static_cast<std::int64_t>(std::clamp(std::floor(x[a] / cell_), -1e18, 1e18));
    }
    return at;
  }
  /// Cubes far apart may share a key; the visitor judges every point anyway.
  static std::uint64_t key(const Index& at) {
    return static_cast<std::uint64_t>(at[0]) * 73856093u ^
           static_cast<std::uint64_t>(at[1]) * 19349663u ^
           static_cast<std::uint64_t>(at[2]) * 83492791u;
  }

  double cell_;
  std::vector<std::int32_t> nodes_;
  std::unordered_map<std::uint64_t, std::vector<std::int32_t>> cells_;
};

/// The point lies in the triangle, edges included, within a distance.
bool lies_in(const std::array<Vec3, 3>& triangle, const Vec3& x, double distance) {
  const Vec3 normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
  const double area = normal.norm();
  if (area == 0 || std::abs(normal.dot(x - triangle[0])) > distance * area) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 edge = triangle[(i + 1) % 3] - triangle[i];
    if (normal.dot(edge.cross(x - triangle[i])) < -distance * area * edge.norm()) return false;
  }
  return true;
}

}  // namespace

void refuse_overlaps(const TetMesh& mesh) {
  const auto faces = sorted_faces(mesh);
  for (std::size_t i = 1; i < faces.size(); ++i) {
    if (faces[i].key != faces[i - 1].key) continue;
    // Of three at one face two lie on the same side.
    if (faces[i].even == faces[i - 1].even) refuse(mesh, faces[i - 1], faces[i]);
    if (i > 1 && faces[i].key == faces[i - 2].key) refuse(mesh, faces[i - 2], faces[i]);
  }
}

std::optional<HangingNode> find_hanging_node(const TetMesh& mesh) {
  const auto faces = sorted_faces(mesh);
  const auto component = node_components(mesh);
  std::vector<Face> boundary;
  std::vector<std::int32_t> corners;
  double edges = 0;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const bool shared = (i > 0 && faces[i].key == faces[i - 1].key) ||
                        (i + 1 < faces.size() && faces[i].key == faces[i + 1].key);
    if (shared) continue;
    boundary.push_back(faces[i]);
    for (std::size_t c = 0; c < 3; ++c) {
      corners.push_back(faces[i].key[c]);
      edges += (position(mesh, faces[i].key[c]) - position(mesh, faces[i].key[(c + 1) % 3])).norm();
    }
  }
  if (boundary.empty()) return std::nullopt;
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  const PointGrid grid(mesh, corners, edges / (3 * static_cast<double>(boundary.size())));
  std::sort(boundary.begin(), boundary.end(),
            [](const Face& a, const Face& b) { return a.element < b.element; });
  for (const auto& face : boundary) {
    std::array<Vec3, 3> triangle;
    double longest = 0;
    for (std::size_t c = 0; c < 3; ++c) triangle[c] = position(mesh, face.corners[c]);
    for (std::size_t c = 0; c < 3; ++c) {
      longest = std::max(longest, (triangle[c] - triangle[(c + 1) % 3]).norm());
    }
    const double distance = 1e-6 * longest;
    const Vec3 margin = Vec3::Constant(distance);
    const Vec3 low = triangle[0].cwiseMin(triangle[1]).cwiseMin(triangle[2]) - margin;
    const Vec3 high = triangle[0].cwiseMax(triangle[1]).cwiseMax(triangle[2]) + margin;
    std::int32_t hanging = -1;
    grid.visit(low, high, [&](std::int32_t n) {
      const auto x = position(mesh, n);
      // Nodes that only coincide with a corner part the body along a slit: whoever made it meant
      // it.
      const bool at_corner = std::any_of(triangle.begin(), triangle.end(), [&](const Vec3& corner) {
        return (corner - x).norm() <= distance;
      });
      const bool same = component[static_cast<std::size_t>(n)] ==
                        component[static_cast<std::size_t>(face.key[0])];
      if (same && !at_corner && lies_in(triangle, x, distance) && (hanging < 0 || n < hanging)) {
        hanging = n;
      }
    });
    if (hanging >= 0) return HangingNode{hanging, static_cast<std::int64_t>(face.element)};
  }
  return std::nullopt;
}

}  // namespace carillon::solvers::mesh
