#include "solvers/mesh/inward_edges.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

namespace carillon::solvers::mesh {
namespace {

/// Edges that turn inward by less are taken for chords of a smooth surface where both faces are
/// plane, and for its approximation where one is curved [rad].
constexpr double min_plane_turn = 15 * std::numbers::pi / 180;
constexpr double min_curved_turn = 2 * std::numbers::pi / 180;
/// Nodes of a plane face lie within this part of its circumference.
constexpr double plane_tolerance = 1e-6;
/// Edges that turn outward by as much bound a section, as those of a bar do [rad].
constexpr double sharp_turn = 60 * std::numbers::pi / 180;

/// A curved boundary face where it meets one of its edges, half-way along.
struct EdgeSide {
  Vec3 normal;  ///< outward
  Vec3 inward;  ///< from the edge into the face, perpendicular to the edge
  bool is_plane;
};

/// @param nodes  of a face, its corners first
bool is_plane(const Eigen::Matrix3Xd& nodes) {
  const Vec3 a = nodes.col(1) - nodes.col(0), b = nodes.col(2) - nodes.col(0);
  const double tolerance = plane_tolerance * (a.norm() + b.norm() + (b - a).norm());
  const Vec3 normal = a.cross(b).normalized();
  return (normal.transpose() * (nodes.colwise() - nodes.col(0))).cwiseAbs().maxCoeff() < tolerance;
}

/// Angle that the body fills at an edge between two faces of its boundary [rad].
double filled_angle(const EdgeSide& one, const EdgeSide& other) {
  const double turn = angle_between(one.normal, other.normal);
  const bool is_inward = one.inward.dot(other.normal) > 0;
  return std::numbers::pi + (is_inward ? turn : -turn);
}

/// Calls visit(from, to, filled angle, whether both faces are plane) for every edge between two
/// faces of the boundary, ascending.
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
    const bool plane = is_plane(nodes);
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Matrix3d by_corner = nodes * gradients[i];
      const auto from = static_cast<Eigen::Index>(i), to = (from + 1) % 3, third = (from + 2) % 3;
      const Vec3 along = (by_corner.col(to) - by_corner.col(from)).normalized();
      const Vec3 normal = along.cross(by_corner.col(third) - by_corner.col(from)).normalized();
      sides[std::minmax(mesh.faces[f + i], mesh.faces[f + (i + 1) % 3])].push_back(
          {normal, normal.cross(along), plane});
    }
  }
  for (const auto& [edge, beside] : sides)
    if (beside.size() == 2)
      visit(edge.first, edge.second, filled_angle(beside[0], beside[1]),
            beside[0].is_plane && beside[1].is_plane);
}

/// Where an edge is farther off than this, polynomials of the next order gain nine tenths.
constexpr double max_rho = 3;

/// The least of an element's six edges.
double rho_of(const TetMesh& mesh, std::size_t element, const InwardEdge& edge) {
  const auto corners = mesh.element(element).first(4);
  double rho = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < i; ++j)
      rho = std::min(rho, passage(mesh, corners[i], corners[j], edge).rho);
  return rho;
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
  for_each_edge(mesh, [&found](std::int32_t from, std::int32_t to, double angle, bool plane) {
    const double min_turn = plane ? min_plane_turn : min_curved_turn;
    if (angle >= std::numbers::pi + min_turn) found.push_back({from, to, edge_exponent(angle)});
  });
  return found;
}

Passage passage(const TetMesh& mesh, std::int32_t one, std::int32_t other, const InwardEdge& edge) {
  const auto at = [&mesh](std::int32_t node) -> const Vec3& {
    return mesh.nodes[static_cast<std::size_t>(node)];
  };
  const Vec3& from = at(edge.from);
  const double length = (at(edge.to) - from).norm();
  const Vec3 along = (at(edge.to) - from) / length;
  const auto across = [&along](const Vec3& v) -> Vec3 { return v - v.dot(along) * along; };
  const Vec3 arm = at(one) - from, line = at(other) - at(one);
  const Vec3 arm_across = across(arm), line_across = across(line);
  const double size = line_across.norm();
  if (!(size > 1e-9 * line.norm())) return {};
  const double share = std::clamp(-arm_across.dot(line_across) / (size * size), 0.0, 1.0);
  // The field varies little along the edge, and beyond its ends as it does across.
  const double height = (arm + share * line).dot(along);
  const double beyond = height - std::clamp(height, 0.0, length);
  const double sum =
      std::hypot(arm_across.norm(), beyond) + std::hypot((arm_across + line_across).norm(), beyond);
  const double axis = std::max(1.0, sum / size);
  return {axis + std::sqrt(axis * axis - 1), share};
}

std::vector<NearestEdge> nearest_edges(const TetMesh& mesh) {
  std::vector<NearestEdge> nearest(mesh.element_count());
  const std::vector<InwardEdge> edges = inward_edges(mesh);
  if (edges.empty()) return nearest;
  std::vector<std::vector<std::size_t>> elements_at(mesh.nodes.size());
  for (std::size_t e = 0; e < mesh.element_count(); ++e)
    for (const std::int32_t corner : mesh.element(e).first(4))
      elements_at[static_cast<std::size_t>(corner)].push_back(e);

  std::vector<std::size_t> seen_from(mesh.element_count(), edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    // Elements that an edge is near to hang together.
    std::vector<std::int32_t> corners{edges[i].from, edges[i].to};
    while (!corners.empty()) {
      const auto corner = static_cast<std::size_t>(corners.back());
      corners.pop_back();
      for (const std::size_t e : elements_at[corner]) {
        if (std::exchange(seen_from[e], i) == i) continue;
        const double rho = rho_of(mesh, e, edges[i]);
        if (rho > max_rho) continue;
        if (rho < nearest[e].rho) nearest[e] = {edges[i].exponent, rho};
        const auto reached = mesh.element(e).first(4);
        corners.insert(corners.end(), reached.begin(), reached.end());
      }
    }
  }
  return nearest;
}

std::vector<bool> between_sharp_edges(const TetMesh& mesh) {
  std::vector<bool> at_node(mesh.nodes.size(), false);
  for_each_edge(mesh, [&at_node](std::int32_t from, std::int32_t to, double angle, bool) {
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
