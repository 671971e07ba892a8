#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "solvers/mesher.hpp"
#include "solvers/node_numbering.hpp"
#include "solvers/quadrature.hpp"

namespace carillon::solvers {
namespace {

using Edge = std::pair<std::int32_t, std::int32_t>;

/// Faces meeting at more than this keep a sharp edge.
const double sharp_angle = 40 * std::numbers::pi / 180;
/// A node that would have to move by more of its edge's length is on the wrong track.
constexpr double largest_move = 0.3;

/// What a boundary edge of the straight mesh sees.
struct BoundaryEdge {
  std::vector<Vec3> normals;   ///< of its faces
  std::vector<Vec3> opposite;  ///< third corners of its faces
};

std::map<Edge, BoundaryEdge> boundary_edges(const TetMesh& linear,
                                            const std::vector<std::int32_t>& faces) {
  std::map<Edge, BoundaryEdge> edges;
  for (std::size_t f = 0; f < faces.size(); f += 3) {
    const auto at = [&](std::size_t i) {
      return linear.nodes[static_cast<std::size_t>(faces[f + i % 3])];
    };
    const Vec3 normal = (at(1) - at(0)).cross(at(2) - at(0)).normalized();
    for (std::size_t i = 0; i < 3; ++i) {
      auto& edge = edges[std::minmax(faces[f + i], faces[f + (i + 1) % 3])];
      edge.normals.push_back(normal);
      edge.opposite.push_back(at(i + 2));
    }
  }
  return edges;
}

Vec3 guarded(const Vec3& from, const Vec3& to, double edge_length) {
  const Vec3 move = to - from;
  return move.allFinite() && move.norm() <= largest_move * edge_length ? move : Vec3(Vec3::Zero());
}

/// Move of a point of the edge ab on to the true surface.
///
/// On a sharp edge the nearest point of the surface would lie on one of the two faces only. From
/// a point pushed off along the bisector (outwards at a convex edge, inwards at a concave one)
/// the nearest point is on the true edge itself: there the edge's normals fan out.
Vec3 edge_move(const BoundaryEdge& edge, const Vec3& a, const Vec3& b, const Vec3& point,
               const SurfaceProjection& project) {
  if (edge.normals.size() != 2) return Vec3::Zero();
  const Vec3 sum = edge.normals[0] + edge.normals[1];
  if (sum.norm() < 1e-6) return Vec3::Zero();  // a knife's edge has no outside
  const Vec3 outward = sum.normalized();
  const double length = (b - a).norm();
  const double angle = std::atan2(edge.normals[0].cross(edge.normals[1]).norm(),
                                  edge.normals[0].dot(edge.normals[1]));
  if (angle <= sharp_angle) return guarded(point, project(point, outward), length);
  const bool convex = (edge.opposite[1] - a).dot(edge.normals[0]) < 0;
  const double push = convex ? 0.25 : -0.12;
  return guarded(point, project(point + push * length * outward, outward), length);
}

/// Moves of the nodes that lie on boundary edges, for one edge its order-1 nodes from the lower
/// vertex on; and the faces of the boundary with their normals.
struct Boundary {
  std::map<Edge, std::vector<Vec3>> edges;
  std::map<std::array<std::int32_t, 3>, Vec3> face_normals;
};

Boundary project_boundary(const TetMesh& linear, int order, const SurfaceProjection& project) {
  Boundary boundary;
  const auto faces = linear.faces.empty() ? boundary_faces(linear) : linear.faces;
  for (const auto& [ends, edge] : boundary_edges(linear, faces)) {
    const Vec3 a = linear.nodes[static_cast<std::size_t>(ends.first)];
    const Vec3 b = linear.nodes[static_cast<std::size_t>(ends.second)];
    auto& moves = boundary.edges[ends];
    for (int k = 1; k < order; ++k)
      moves.push_back(edge_move(edge, a, b, a + (b - a) * k / order, project));
  }
  for (std::size_t f = 0; f < faces.size(); f += 3) {
    std::array<std::int32_t, 3> key{faces[f], faces[f + 1], faces[f + 2]};
    const auto at = [&](std::size_t i) { return linear.nodes[static_cast<std::size_t>(key[i])]; };
    const Vec3 normal = (at(1) - at(0)).cross(at(2) - at(0)).normalized();
    std::sort(key.begin(), key.end());
    boundary.face_normals[key] = normal;
  }
  return boundary;
}

/// Moves of a straight element's nodes: those on edges as projected, those in faces and inside by
/// blending, those in boundary faces projected once more from there.
class NodeMover {
 public:
  using Corners4 = std::span<const std::int32_t>;
  using Lattice = std::array<int, 4>;

  NodeMover(const TetMesh& linear, int order, const Boundary& boundary,
            const SurfaceProjection& project)
      : linear_(linear), order_(order), boundary_(boundary), project_(project) {}

  Vec3 straight(Corners4 corners, const Lattice& at) const {
    Vec3 p = Vec3::Zero();
    for (std::size_t i = 0; i < 4; ++i) p += share(at[i]) * vertex(corners[i]);
    return p;
  }

  Vec3 move(Corners4 corners, const Lattice& at) const {
    const Vec3 edges = edge_blends(corners, at);
    const auto zeros = std::count(at.begin(), at.end(), 0);
    if (zeros == 1) return edges + face_rest(corners, at, edges);
    if (zeros > 1) return edges;
    Vec3 inside = edges;
    for (std::size_t opposite = 0; opposite < 4; ++opposite) {
      Vec3 rest = Vec3::Zero();
      double bubbles = 0;
      for (const Lattice& node : tetrahedron_lattice(order_))
        if (node[opposite] == 0 && std::count(node.begin(), node.end(), 0) == 1) {
          rest += face_rest(corners, node, edge_blends(corners, node));
          bubbles += bubble(node, opposite);
        }
      if (bubbles > 0) inside += bubble(at, opposite) / bubbles * rest;
    }
    return inside;
  }

 private:
  double share(int weight) const { return static_cast<double>(weight) / order_; }
  const Vec3& vertex(std::int32_t v) const { return linear_.nodes[static_cast<std::size_t>(v)]; }

  /// Moves of an edge's nodes divided by t (1 - t), interpolated at t, times the barycentrics of
  /// both ends: the blending of Szabo and Babuska (1991), a polynomial of the element's order.
  Vec3 edge_blend(std::int32_t from, std::int32_t to, double b_from, double b_to) const {
    if (from > to) {
      std::swap(from, to);
      std::swap(b_from, b_to);
    }
    const auto found = boundary_.edges.find({from, to});
    if (found == boundary_.edges.end()) return Vec3::Zero();
    const double t = 0.5 * (1 + b_to - b_from);
    Vec3 sum = Vec3::Zero();
    for (int k = 1; k < order_; ++k) {
      double basis = 1 / (share(k) * (1 - share(k)));
      for (int j = 1; j < order_; ++j)
        if (j != k) basis *= (t * order_ - j) / (k - j);
      sum += basis * found->second[static_cast<std::size_t>(k - 1)];
    }
    return b_from * b_to * sum;
  }

  Vec3 edge_blends(Corners4 corners, const Lattice& at) const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j)
        if (at[i] > 0 && at[j] > 0)
          sum += edge_blend(corners[i], corners[j], share(at[i]), share(at[j]));
    return sum;
  }

  /// What projection adds to the blended edges at a node inside a face; zero inside the body.
  Vec3 face_rest(Corners4 corners, const Lattice& at, const Vec3& edges) const {
    std::array<std::int32_t, 3> face{};
    std::size_t count = 0;
    for (std::size_t i = 0; i < 4; ++i)
      if (at[i] > 0) face[count++] = corners[i];
    std::sort(face.begin(), face.end());
    const auto normal = boundary_.face_normals.find(face);
    if (normal == boundary_.face_normals.end()) return Vec3::Zero();
    const Vec3 from = straight(corners, at) + edges;
    const double shortest = std::min({(vertex(face[0]) - vertex(face[1])).norm(),
                                      (vertex(face[1]) - vertex(face[2])).norm(),
                                      (vertex(face[2]) - vertex(face[0])).norm()});
    return guarded(from, project_(from, normal->second), shortest);
  }

  /// Product of a face's barycentrics.
  double bubble(const Lattice& at, std::size_t opposite) const {
    double product = 1;
    for (std::size_t i = 0; i < 4; ++i)
      if (i != opposite) product *= share(at[i]);
    return product;
  }

  const TetMesh& linear_;
  int order_;
  const Boundary& boundary_;
  const SurfaceProjection& project_;
};

/// Derivatives of the shape functions where the sign of the Jacobian is sampled: the nodes of
/// order 4 and the points of a rule that integrates the stiffness.
std::vector<Eigen::Matrix<double, Eigen::Dynamic, 3>> sampled_gradients(int order) {
  std::vector<Eigen::Vector4d> points = tetrahedron_rule(order + 1).barycentric;
  for (const auto& at : tetrahedron_lattice(4))
    points.emplace_back(at[0] / 4.0, at[1] / 4.0, at[2] / 4.0, at[3] / 4.0);
  std::vector<Eigen::Matrix<double, Eigen::Dynamic, 3>> gradients;
  for (const auto& point : points) {
    Eigen::Matrix<double, Eigen::Dynamic, 4> by_barycentric;
    tetrahedron_shape_functions(order, point, &by_barycentric);
    gradients.push_back(by_barycentric.rightCols<3>().colwise() - by_barycentric.col(0));
  }
  return gradients;
}

/// Elements whose Jacobian falls below a twentieth of the straight element's somewhere.
std::vector<std::size_t> folded_elements(const TetMesh& mesh) {
  constexpr double least_share = 0.05;
  const auto gradients = sampled_gradients(mesh.order);
  std::vector<std::size_t> folded;
  Eigen::Matrix<double, 3, Eigen::Dynamic> nodes(3, nodes_per_tetrahedron(mesh.order));
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto element = mesh.element(e);
    for (std::size_t n = 0; n < element.size(); ++n)
      nodes.col(static_cast<Eigen::Index>(n)) = mesh.nodes[static_cast<std::size_t>(element[n])];
    const double straight = (nodes.col(1) - nodes.col(0))
                                .cross(nodes.col(2) - nodes.col(0))
                                .dot(nodes.col(3) - nodes.col(0));
    for (const auto& gradient : gradients)
      if ((nodes * gradient).determinant() < least_share * straight) {
        folded.push_back(e);
        break;
      }
  }
  return folded;
}

/// Pulls the boundary edges and faces of an element back to the chord; whether there were any.
bool straighten(Boundary& boundary, std::span<const std::int32_t> corners) {
  std::size_t erased = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    std::array<std::int32_t, 3> face{corners[(i + 1) % 4], corners[(i + 2) % 4],
                                     corners[(i + 3) % 4]};
    std::sort(face.begin(), face.end());
    erased += boundary.face_normals.erase(face);
    for (std::size_t j = i + 1; j < 4; ++j)
      erased += boundary.edges.erase(std::minmax(corners[i], corners[j]));
  }
  return erased > 0;
}

}  // namespace

TetMesh elevate(const TetMesh& linear, int order, const SurfaceProjection& project,
                std::int64_t& straightened) {
  straightened = 0;
  std::vector<Corners> corners(linear.element_count());
  for (std::size_t e = 0; e < corners.size(); ++e)
    std::copy_n(linear.element(e).begin(), 4, corners[e].begin());
  const auto numbering =
      number_nodes(corners, static_cast<std::int32_t>(linear.nodes.size()), order);
  const auto& lattice = tetrahedron_lattice(order);

  TetMesh mesh;
  mesh.order = order;
  mesh.elements = numbering.elements;
  mesh.regions = linear.regions;
  mesh.region_names = linear.region_names;
  mesh.nodes = linear.nodes;
  mesh.nodes.resize(numbering.first_use.size());

  const bool curved = project && order > 1;
  Boundary boundary = curved ? project_boundary(linear, order, project) : Boundary{};
  const NodeMover mover(linear, order, boundary, project);
  std::vector<bool> was_folded(corners.size(), false);
  for (bool changed = true; changed;) {
    for (std::size_t n = linear.nodes.size(); n < mesh.nodes.size(); ++n) {
      const auto use = static_cast<std::size_t>(numbering.first_use[n]);
      const auto& element = corners[use / lattice.size()];
      const auto& at = lattice[use % lattice.size()];
      mesh.nodes[n] = mover.straight(element, at);
      if (curved) mesh.nodes[n] += mover.move(element, at);
    }
    changed = false;
    if (!curved) break;
    for (std::size_t e : folded_elements(mesh))
      if (straighten(boundary, corners[e])) {
        changed = true;
        if (!was_folded[e]) ++straightened;
        was_folded[e] = true;
      }
  }
  mesh.faces = boundary_faces(mesh);
  return mesh;
}

}  // namespace carillon::solvers
