#include "solvers/mesh/curve_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "solvers/elements/node_numbering.hpp"
#include "solvers/mesh/detail/folded_elements.hpp"
#include "solvers/mesh/raise_order.hpp"

namespace carillon::solvers::mesh {
namespace {

using NodePair = std::pair<std::int32_t, std::int32_t>;

/// A node that would have to move by more of its edge's length is on the wrong track.
constexpr double largest_move = 0.3;

/// Normals of the straight faces beside each boundary edge.
std::map<NodePair, std::vector<Vec3>> edge_normals(const TetMesh& mesh) {
  std::map<NodePair, std::vector<Vec3>> edges;
  const auto per_face = static_cast<std::size_t>(elements::nodes_per_face(mesh.order));
  for (std::size_t f = 0; f < mesh.faces.size(); f += per_face) {
    const auto at = [&](std::size_t i) {
      return mesh.nodes[static_cast<std::size_t>(mesh.faces[f + i % 3])];
    };
    const Vec3 normal = (at(1) - at(0)).cross(at(2) - at(0)).normalized();
    for (std::size_t i = 0; i < 3; ++i)
      edges[std::minmax(mesh.faces[f + i], mesh.faces[f + (i + 1) % 3])].push_back(normal);
  }
  return edges;
}

Vec3 guarded(const Vec3& from, const Vec3& to, double edge_length) {
  const Vec3 move = to - from;
  return move.allFinite() && move.norm() <= largest_move * edge_length ? move : Vec3(Vec3::Zero());
}

/// Move of a point of the edge ab on to the true surface; on a sharp edge, on to its line, as the
/// nearest point of the surface would lie on one of the two faces only.
Vec3 edge_move(const std::vector<Vec3>& normals, const Vec3& a, const Vec3& b, const Vec3& point,
               const SurfaceProjection& truth) {
  if (normals.size() != 2) return Vec3::Zero();
  const Vec3 sum = normals[0] + normals[1];
  if (sum.norm() < 1e-6) return Vec3::Zero();  // a knife's edge has no outside
  const double length = (b - a).norm();
  if (truth.to_line && angle_between(normals[0], normals[1]) > truth.line_angle)
    if (const auto on_line = truth.to_line(a, b, point)) return guarded(point, *on_line, length);
  return guarded(point, truth.to_surface(point, sum.normalized()), length);
}

/// Moves of the nodes that lie on boundary edges, for one edge its order-1 nodes from the lower
/// vertex on; and the faces of the boundary with their normals.
struct Boundary {
  std::map<NodePair, std::vector<Vec3>> edges;
  std::map<std::array<std::int32_t, 3>, Vec3> face_normals;
};

Boundary project_boundary(const TetMesh& mesh, const SurfaceProjection& truth) {
  Boundary boundary;
  const auto seen = edge_normals(mesh);
  const auto& lattice = elements::tetrahedron_lattice(mesh.order);
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto element = mesh.element(e);
    for (std::size_t n = 4; n < lattice.size(); ++n) {
      std::array<std::size_t, 4> ends{};
      std::size_t count = 0;
      for (std::size_t i = 0; i < 4; ++i)
        if (lattice[n][i] > 0) ends[count++] = i;
      if (count != 2) continue;
      if (element[ends[0]] > element[ends[1]]) std::swap(ends[0], ends[1]);
      const NodePair key{element[ends[0]], element[ends[1]]};
      const auto edge = seen.find(key);
      if (edge == seen.end()) continue;
      auto& moves = boundary.edges[key];
      if (moves.empty()) {
        // Not a number: not met yet.
        moves.assign(static_cast<std::size_t>(mesh.order - 1), Vec3::Constant(std::nan("")));
      }
      Vec3& move = moves[static_cast<std::size_t>(lattice[n][ends[1]] - 1)];
      if (!std::isnan(move.x())) continue;
      const auto node = [&](std::int32_t i) { return mesh.nodes[static_cast<std::size_t>(i)]; };
      move = edge_move(edge->second, node(key.first), node(key.second), node(element[n]), truth);
    }
  }
  const auto per_face = static_cast<std::size_t>(elements::nodes_per_face(mesh.order));
  for (std::size_t f = 0; f < mesh.faces.size(); f += per_face) {
    std::array<std::int32_t, 3> key{mesh.faces[f], mesh.faces[f + 1], mesh.faces[f + 2]};
    const auto at = [&](std::size_t i) { return mesh.nodes[static_cast<std::size_t>(key[i])]; };
    const Vec3 normal = (at(1) - at(0)).cross(at(2) - at(0)).normalized();
    std::sort(key.begin(), key.end());
    boundary.face_normals[key] = normal;
  }
  return boundary;
}

/// Moves of an element's nodes: those on edges as projected, those in faces and inside by blending,
/// those in boundary faces projected once more from there.
class NodeMover {
 public:
  NodeMover(const TetMesh& base, const Boundary& boundary, const SurfaceProjection& truth)
      : base_(base),
        lattice_(elements::tetrahedron_lattice(base.order)),
        boundary_(boundary),
        truth_(truth) {}

  /// @param n  local number of the node in element e
  Vec3 move(std::size_t e, std::size_t n) const {
    const Vec3 edges = edge_blends(e, n);
    const auto zeros = zeros_of(n);
    if (zeros == 1) return edges + face_rest(e, n, edges);
    if (zeros > 1) return edges;
    Vec3 inside = edges;
    for (std::size_t opposite = 0; opposite < 4; ++opposite) {
      Vec3 rest = Vec3::Zero();
      double bubbles = 0;
      for (std::size_t on_face = 0; on_face < lattice_.size(); ++on_face)
        if (lattice_[on_face][opposite] == 0 && zeros_of(on_face) == 1) {
          rest += face_rest(e, on_face, edge_blends(e, on_face));
          bubbles += bubble(on_face, opposite);
        }
      if (bubbles > 0) inside += bubble(n, opposite) / bubbles * rest;
    }
    return inside;
  }

 private:
  double fraction(int weight) const { return static_cast<double>(weight) / base_.order; }
  const Vec3& node(std::int32_t n) const { return base_.nodes[static_cast<std::size_t>(n)]; }
  std::ptrdiff_t zeros_of(std::size_t n) const {
    return std::count(lattice_[n].begin(), lattice_[n].end(), 0);
  }

  /// Moves of an edge's nodes divided by t (1 - t), interpolated at t, times the barycentrics of
  /// both ends: the blending of Szabo and Babuska (1991), a polynomial of the element's order.
  Vec3 edge_blend(std::int32_t from, std::int32_t to, double b_from, double b_to) const {
    if (from > to) {
      std::swap(from, to);
      std::swap(b_from, b_to);
    }
    const auto found = boundary_.edges.find({from, to});
    if (found == boundary_.edges.end()) return Vec3::Zero();
    const int order = base_.order;
    const double t = 0.5 * (1 + b_to - b_from);
    Vec3 sum = Vec3::Zero();
    for (int k = 1; k < order; ++k) {
      double basis = 1 / (fraction(k) * (1 - fraction(k)));
      for (int j = 1; j < order; ++j)
        if (j != k) basis *= (t * order - j) / (k - j);
      sum += basis * found->second[static_cast<std::size_t>(k - 1)];
    }
    return b_from * b_to * sum;
  }

  Vec3 edge_blends(std::size_t e, std::size_t n) const {
    const auto corners = base_.element(e);
    const auto& at = lattice_[n];
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j)
        if (at[i] > 0 && at[j] > 0)
          sum += edge_blend(corners[i], corners[j], fraction(at[i]), fraction(at[j]));
    return sum;
  }

  /// What projection adds to the blended edges at a node inside a face; zero inside the body.
  Vec3 face_rest(std::size_t e, std::size_t n, const Vec3& edges) const {
    const auto element = base_.element(e);
    std::array<std::int32_t, 3> face{};
    std::size_t count = 0;
    for (std::size_t i = 0; i < 4; ++i)
      if (lattice_[n][i] > 0) face[count++] = element[i];
    std::sort(face.begin(), face.end());
    const auto normal = boundary_.face_normals.find(face);
    if (normal == boundary_.face_normals.end()) return Vec3::Zero();
    const Vec3 from = node(element[n]) + edges;
    const double shortest =
        std::min({(node(face[0]) - node(face[1])).norm(), (node(face[1]) - node(face[2])).norm(),
                  (node(face[2]) - node(face[0])).norm()});
    return guarded(from, truth_.to_surface(from, normal->second), shortest);
  }

  /// Product of a face's barycentrics.
  double bubble(std::size_t n, std::size_t opposite) const {
    double product = 1;
    for (std::size_t i = 0; i < 4; ++i)
      if (i != opposite) product *= fraction(lattice_[n][i]);
    return product;
  }

  const TetMesh& base_;
  const std::vector<std::array<int, 4>>& lattice_;
  const Boundary& boundary_;
  const SurfaceProjection& truth_;
};

/// Leaves the boundary edges and faces of an element where they were; whether there were any.
bool hold_back(Boundary& boundary, std::span<const std::int32_t> corners) {
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

/// What moving nodes on to the true surface left undone.
struct HeldBack {
  std::int64_t elements = 0;  ///< that would fold and keep their boundary as it was
  std::vector<Vec3> gaps;     ///< from each node to where it should be [m]; empty: all zero
};

/// Moves the nodes of boundary edges and faces on to the true surface, and those inside along.
HeldBack move_to_surface(TetMesh& mesh, const SurfaceProjection& truth) {
  const TetMesh base = mesh;
  Boundary boundary = project_boundary(base, truth);
  const NodeMover mover(base, boundary, truth);
  const auto per_element = static_cast<std::size_t>(elements::nodes_per_tetrahedron(mesh.order));
  std::vector<bool> was_folded(mesh.element_count(), false);
  HeldBack out;
  std::vector<Vec3> wanted;
  for (bool changed = true; changed;) {
    std::vector<bool> placed(mesh.nodes.size(), false);
    for (std::size_t e = 0; e < mesh.element_count(); ++e)
      for (std::size_t n = 4; n < per_element; ++n) {
        const auto node = static_cast<std::size_t>(mesh.element(e)[n]);
        if (placed[node]) continue;
        placed[node] = true;
        mesh.nodes[node] = base.nodes[node] + mover.move(e, n);
      }
    if (wanted.empty()) wanted = mesh.nodes;
    changed = false;
    for (std::size_t e : folded_elements(mesh))
      if (hold_back(boundary, mesh.element(e).first(4))) {
        changed = true;
        if (!was_folded[e]) ++out.elements;
        was_folded[e] = true;
      }
  }
  if (out.elements == 0) return out;
  out.gaps = std::move(wanted);
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) out.gaps[n] -= mesh.nodes[n];
  return out;
}

/// Straight elements of an order; corners keep their numbers.
TetMesh straight_elements(const TetMesh& linear, int order) {
  std::vector<elements::Corners> corners(linear.element_count());
  for (std::size_t e = 0; e < corners.size(); ++e)
    std::copy_n(linear.element(e).begin(), 4, corners[e].begin());
  TetMesh mesh = raise_order(
      linear, order,
      elements::number_nodes(corners, static_cast<std::int32_t>(linear.nodes.size()), order));
  // Sums would turn -0 into 0.
  std::copy(linear.nodes.begin(), linear.nodes.end(), mesh.nodes.begin());
  return mesh;
}

}  // namespace

TetMesh curve_mesh(const TetMesh& linear, int order, const SurfaceProjection& truth,
                   std::int64_t& straightened) {
  straightened = 0;
  TetMesh mesh = straight_elements(linear, order);
  if (!truth.to_surface) return mesh;
  if (order > 1) straightened = move_to_surface(mesh, truth).elements;
  TetMesh finer = raise_order(mesh, order + 1);
  mesh.finer_gaps = move_to_surface(finer, truth).gaps;
  mesh.finer_nodes = std::move(finer.nodes);
  return mesh;
}

}  // namespace carillon::solvers::mesh
