#include "solvers/mesh/inward_edges.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace carillon::solvers::mesh {
namespace {

/// Edges that turn inward by less are taken for chords of a smooth surface [rad].
constexpr double min_turn = 15 * std::numbers::pi / 180;
/// Edges that turn outward by as much bound a section, as those of a bar do [rad].
constexpr double sharp_turn = 60 * std::numbers::pi / 180;

/// A curved boundary face where it meets one of its edges, half-way along.
struct EdgeSide {
  Vec3 normal;  ///< outward
  Vec3 inward;  ///< from the edge into the face, perpendicular to the edge
};

/// Angle that the body fills at an edge between two faces of its boundary [rad].
double filled_angle(const EdgeSide& one, const EdgeSide& other) {
  const double turn = angle_between(one.normal, other.normal);
  const bool is_inward = one.inward.dot(other.normal) > 0;
  return std::numbers::pi + (is_inward ? turn : -turn);
}

/// Calls visit(from, to, filled angle) for every edge between two faces of the boundary, ascending.
template <class Visit>
void for_each_edge(const TetMesh& mesh, Visit visit) {
  // Gradients of the shape functions half-way along the edges (01), (12), (20) of a face.
  std::array<Eigen::Matrix<double, Eigen::Dynamic, 3>, 3> gradients;
  for (std::size_t i = 0; i < 3; ++i) {
    Eigen::Vector3d half = Eigen::Vector3d::Constant(0.5);
    half[static_cast<Eigen::Index>((i + 2) % 3)] = 0;
    elements::triangle_shape_functions(mesh.order, half, &gradients[i]);
  }
  std::map<std::pair<std::int32_t, std::int32_t>, std::vector<EdgeSide>> sides;
  const auto per_face = static_cast<std::size_t>(elements::nodes_per_face(mesh.order));
  Eigen::Matrix3Xd nodes(3, per_face);
  for (std::size_t f = 0; f < mesh.faces.size(); f += per_face) {
    for (std::size_t n = 0; n < per_face; ++n)
      nodes.col(static_cast<Eigen::Index>(n)) =
          mesh.nodes[static_cast<std::size_t>(mesh.faces[f + n])];
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Matrix3d by_corner = nodes * gradients[i];
      const auto from = static_cast<Eigen::Index>(i), to = (from + 1) % 3, third = (from + 2) % 3;
      const Vec3 along = (by_corner.col(to) - by_corner.col(from)).normalized();
      const Vec3 normal = along.cross(by_corner.col(third) - by_corner.col(from)).normalized();
      sides[std::minmax(mesh.faces[f + i], mesh.faces[f + (i + 1) % 3])].push_back(
          {normal, normal.cross(along)});
    }
  }
  for (const auto& [edge, beside] : sides)
    if (beside.size() == 2) visit(edge.first, edge.second, filled_angle(beside[0], beside[1]));
}

}  // namespace

double edge_exponent(double angle) {
  constexpr double pi = std::numbers::pi;
  if (!(angle > pi)) return 1;
  double low = 0.5, high = 1;
  constexpr int halvings = 40;
  for (int i = 0; i < halvings; ++i) {
    const double middle = (low + high) / 2;
    (std::sin(middle * angle) + middle * std::sin(angle) > 0 ? low : high) = middle;
  }
  return (low + high) / 2;
}

std::vector<InwardEdge> inward_edges(const TetMesh& mesh) {
  std::vector<InwardEdge> found;
  for_each_edge(mesh, [&found](std::int32_t from, std::int32_t to, double angle) {
    if (angle >= std::numbers::pi + min_turn) found.push_back({from, to, edge_exponent(angle)});
  });
  return found;
}

std::vector<double> edge_exponents(const TetMesh& mesh) {
  std::vector<double> at_node(mesh.nodes.size(), 1);
  for (const InwardEdge& edge : inward_edges(mesh))
    for (const std::int32_t end : {edge.from, edge.to}) {
      double& exponent = at_node[static_cast<std::size_t>(end)];
      exponent = std::min(exponent, edge.exponent);
    }
  std::vector<double> exponents(mesh.element_count(), 1);
  for (std::size_t e = 0; e < exponents.size(); ++e)
    for (const std::int32_t corner : mesh.element(e).first(4))
      exponents[e] = std::min(exponents[e], at_node[static_cast<std::size_t>(corner)]);
  return exponents;
}

std::vector<bool> between_sharp_edges(const TetMesh& mesh) {
  std::vector<bool> at_node(mesh.nodes.size(), false);
  for_each_edge(mesh, [&at_node](std::int32_t from, std::int32_t to, double angle) {
    if (angle > std::numbers::pi - sharp_turn) return;
    for (const std::int32_t end : {from, to}) at_node[static_cast<std::size_t>(end)] = true;
  });
  std::vector<bool> found(mesh.element_count());
  for (std::size_t e = 0; e < found.size(); ++e) {
    const auto corners = mesh.element(e).first(4);
    found[e] = std::all_of(corners.begin(), corners.end(), [&at_node](std::int32_t corner) {
      return at_node[static_cast<std::size_t>(corner)];
    });
  }
  return found;
}

}  // namespace carillon::solvers::mesh
