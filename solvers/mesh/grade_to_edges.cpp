#include "solvers/mesh/grade_to_edges.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include "core/disjoint_sets.hpp"
#include "core/numbers.hpp"
#include "solvers/elements/node_numbering.hpp"
#include "solvers/mesh/inward_edges.hpp"
#include "solvers/mesh/raise_order.hpp"

namespace carillon::solvers::mesh {
namespace {

/// Edges that turn by less are no features of a body (tetrahedra/detail/feature_lines.hpp), and
/// smooth enough as they are [rad].
constexpr double graded_turn = 40 * std::numbers::pi / 180;

/// Lines of edges whose extent is below this part of a median element's side, spikes of a scan,
/// say, hold less of a mode than its elements leave out.
constexpr double min_extent_ratio = 0.2;

/// The side of a regular tetrahedron of the median volume [m].
double median_side(const TetMesh& mesh) {
  std::vector<double> volumes;
  for (std::size_t e = 0; e < mesh.element_count(); ++e) volumes.push_back(six_volumes(mesh, e));
  return std::cbrt(std::numbers::sqrt2 * core::median(std::move(volumes)));
}

/// The inward edges that layers follow.
std::vector<InwardEdge> graded_edges(const TetMesh& mesh) {
  const double sharp = edge_exponent(std::numbers::pi + graded_turn);
  std::vector<InwardEdge> edges = inward_edges(mesh);
  std::erase_if(edges, [sharp](const InwardEdge& edge) { return edge.exponent > sharp; });
  if (edges.empty()) return edges;
  core::DisjointSets lines(mesh.nodes.size());
  for (const InwardEdge& edge : edges)
    lines.join(static_cast<std::size_t>(edge.from), static_cast<std::size_t>(edge.to));
  const auto line_of = [&lines](const InwardEdge& edge) {
    return lines.find(static_cast<std::size_t>(edge.from));
  };
  std::map<std::size_t, Eigen::AlignedBox3d> extents;
  for (const InwardEdge& edge : edges)
    for (const std::int32_t n : {edge.from, edge.to})
      extents[line_of(edge)].extend(mesh.nodes[static_cast<std::size_t>(n)]);
  const double min_extent = min_extent_ratio * median_side(mesh);
  std::erase_if(edges, [&](const InwardEdge& edge) {
    return extents.at(line_of(edge)).diagonal().norm() < min_extent;
  });
  return edges;
}

/// Sides of elements that an inward edge passes so near (Passage::rho) are cut there: elements of
/// any order leave out what goes on at the edge.
constexpr double near_passage = 1.6;

using Edge = std::pair<std::int32_t, std::int32_t>;

/// A vertex of a piece, and where it lies in the element that the piece is of.
struct PieceCorner {
  std::int32_t vertex;
  Eigen::Vector4d at;  ///< barycentric
};

/// A tetrahedron in an element's own coordinates.
struct Piece {
  std::size_t element;
  std::array<PieceCorner, 4> corners;
};

/// Elements cut into pieces. Neighbours agree about the cuts of the face between them: new vertices
/// belong to edges, and a quadrilateral's diagonal starts at its lowest vertex.
class Pieces {
 public:
  explicit Pieces(const TetMesh& mesh) : mesh_(mesh) {
    const auto numbering = numbering_at(mesh, 1);
    std::vector<std::int32_t> vertex_of(mesh.nodes.size(), -1);
    for (std::size_t e = 0; e < mesh.element_count(); ++e) {
      Piece piece{e, {}};
      for (std::size_t i = 0; i < 4; ++i) {
        const std::int32_t vertex = numbering.elements[4 * e + i];
        vertex_of[static_cast<std::size_t>(mesh.element(e)[i])] = vertex;
        vertices_ = std::max(vertices_, vertex + 1);
        piece.corners[i] = {vertex, Eigen::Vector4d::Unit(static_cast<Eigen::Index>(i))};
      }
      pieces_.push_back(piece);
    }
    at_edge_.assign(static_cast<std::size_t>(vertices_), false);
    std::multimap<std::int32_t, InwardEdge> edges_at;
    for (const InwardEdge& edge : graded_edges(mesh)) {
      const auto from = vertex_of[static_cast<std::size_t>(edge.from)];
      const auto to = vertex_of[static_cast<std::size_t>(edge.to)];
      inward_.insert(std::minmax(from, to));
      at_edge_[static_cast<std::size_t>(from)] = at_edge_[static_cast<std::size_t>(to)] = true;
      edges_at.emplace(from, edge);
      edges_at.emplace(to, edge);
    }
    for (const Piece& piece : pieces_)
      for (const PieceCorner& corner : piece.corners) {
        const auto [first, last] = edges_at.equal_range(corner.vertex);
        for (auto edge = first; edge != last; ++edge) find_passed_sides(piece, edge->second);
      }
  }

  bool has_edges() const { return !inward_.empty(); }

  /// Halves what joins two inward edges, so that each piece is at one alone, and cuts what one
  /// passes.
  void part_edges() {
    std::vector<Piece> before;
    std::swap(before, pieces_);
    for (const Piece& piece : before) part(piece);
    new_vertices_.clear();
  }

  void add_layer() {
    std::vector<Piece> before;
    std::swap(before, pieces_);
    for (const Piece& piece : before) cut(piece);
    new_vertices_.clear();
  }

  TetMesh mesh() const {
    std::vector<elements::Corners> corners;
    TetMesh out;
    out.order = mesh_.order;
    out.region_names = mesh_.region_names;
    for (const Piece& piece : pieces_) {
      corners.push_back({piece.corners[0].vertex, piece.corners[1].vertex, piece.corners[2].vertex,
                         piece.corners[3].vertex});
      out.regions.push_back(mesh_.regions[piece.element]);
    }
    elements::NodeNumbering numbering = elements::number_nodes(corners, vertices_, mesh_.order);
    out.nodes = values_at(numbering, mesh_, mesh_.nodes);
    out.elements = std::move(numbering.elements);
    out.faces = boundary_faces(out);
    if (!mesh_.finer_nodes.empty()) {
      const TetMesh finer = next_order(mesh_);
      const auto finer_numbering = numbering_at(out, finer.order);
      out.finer_nodes = values_at(finer_numbering, finer, finer.nodes);
      if (!mesh_.finer_gaps.empty())
        out.finer_gaps = values_at(finer_numbering, finer, mesh_.finer_gaps);
    }
    return out;
  }

 private:
  bool is_at_edge(const PieceCorner& corner) const {
    return at_edge_[static_cast<std::size_t>(corner.vertex)];
  }
  bool is_inward(const PieceCorner& a, const PieceCorner& b) const {
    return inward_.count(std::minmax(a.vertex, b.vertex)) > 0;
  }

  /// The sides of an element that an inward edge at one of its corners passes.
  void find_passed_sides(const Piece& piece, const InwardEdge& edge) {
    const auto nodes = mesh_.element(piece.element);
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < 4; ++j) {
        const PieceCorner &a = piece.corners[i], &b = piece.corners[j];
        if (a.vertex >= b.vertex || is_at_edge(a) || is_at_edge(b)) continue;
        const Passage passed = passage(mesh_, nodes[i], nodes[j], edge);
        if (passed.rho > near_passage) continue;
        Passage& nearest = passed_[{a.vertex, b.vertex}];
        if (passed.rho < nearest.rho) nearest = passed;
      }
  }

  /// A vertex between two others, the same for all pieces that share them.
  PieceCorner between(const PieceCorner& from, const PieceCorner& to, double share) {
    const auto [found, is_new] =
        new_vertices_.try_emplace(std::minmax(from.vertex, to.vertex), vertices_);
    if (is_new) {
      ++vertices_;
      at_edge_.push_back(false);
    }
    return {found->second, (1 - share) * from.at + share * to.at};
  }

  /// Edges are cut in the order of their vertices, whichever piece they are met in.
  void part(const Piece& piece) {
    Edge lowest{-1, -1};
    std::size_t from = 0, to = 0;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const PieceCorner &a = piece.corners[i], &b = piece.corners[j];
        const Edge edge = std::minmax(a.vertex, b.vertex);
        const bool joins = is_at_edge(a) && is_at_edge(b) && !is_inward(a, b);
        if (!joins && passed_.count(edge) == 0) continue;
        if (lowest.first >= 0 && lowest < edge) continue;
        lowest = edge;
        from = i;
        to = j;
      }
    if (lowest.first < 0) {
      pieces_.push_back(piece);
      return;
    }
    if (piece.corners[from].vertex > piece.corners[to].vertex) std::swap(from, to);
    const auto passed = passed_.find(lowest);
    const PieceCorner half =
        between(piece.corners[from], piece.corners[to],
                passed == passed_.end() ? 0.5 : std::clamp(passed->second.share, 0.25, 0.75));
    Piece one = piece, other = piece;
    one.corners[from] = half;
    other.corners[to] = half;
    part(one);
    part(other);
  }

  void cut(const Piece& piece) {
    std::array<PieceCorner, 4> c = piece.corners;
    const auto away = std::stable_partition(c.begin(), c.end(),
                                            [this](const PieceCorner& p) { return is_at_edge(p); });
    const auto at_edge = away - c.begin();
    const auto near = [&](std::size_t edge, std::size_t far) {
      return between(c[edge], c[far], layer_ratio);
    };
    if (at_edge == 1) {
      const std::array<PieceCorner, 3> inner{near(0, 1), near(0, 2), near(0, 3)};
      add(piece.element, {c[0], inner[0], inner[1], inner[2]});
      add_prism(piece.element, inner, {c[1], c[2], c[3]});
    } else if (at_edge == 2) {
      const PieceCorner n02 = near(0, 2), n03 = near(0, 3), n12 = near(1, 2), n13 = near(1, 3);
      add_prism(piece.element, {c[0], n02, n03}, {c[1], n12, n13});
      add_prism(piece.element, {c[2], n02, n12}, {c[3], n03, n13});
    } else if (at_edge == 3) {
      const std::array<PieceCorner, 3> inner{near(0, 3), near(1, 3), near(2, 3)};
      add_prism(piece.element, {c[0], c[1], c[2]}, inner);
      add(piece.element, {inner[0], inner[1], inner[2], c[3]});
    } else {
      pieces_.push_back(piece);
    }
  }

  /// A piece, turned the right way.
  void add(std::size_t element, std::array<PieceCorner, 4> corners) {
    Eigen::Matrix4d at;
    for (Eigen::Index i = 0; i < 4; ++i) at.col(i) = corners[static_cast<std::size_t>(i)].at;
    if (at.determinant() < 0) std::swap(corners[2], corners[3]);
    pieces_.push_back({element, corners});
  }

  /// Three tetrahedra (Dompierre, Labbe, Vallet and Camarero 1999).
  void add_prism(std::size_t element, std::array<PieceCorner, 3> a, std::array<PieceCorner, 3> b) {
    // The lowest vertex comes first; two of the quadrilaterals' diagonals start there.
    const auto lower = [](const PieceCorner& one, const PieceCorner& other) {
      return one.vertex < other.vertex;
    };
    const auto lowest_a = std::min_element(a.begin(), a.end(), lower);
    const auto lowest_b = std::min_element(b.begin(), b.end(), lower);
    const bool in_a = lower(*lowest_a, *lowest_b);
    const auto turn = in_a ? lowest_a - a.begin() : lowest_b - b.begin();
    std::rotate(a.begin(), a.begin() + turn, a.end());
    std::rotate(b.begin(), b.begin() + turn, b.end());
    if (!in_a) std::swap(a, b);
    add(element, {a[0], b[0], b[1], b[2]});
    const bool from_a1 = std::min(a[1].vertex, b[2].vertex) < std::min(a[2].vertex, b[1].vertex);
    if (from_a1) {
      add(element, {a[0], a[1], a[2], b[2]});
      add(element, {a[0], a[1], b[2], b[1]});
    } else {
      add(element, {a[0], a[1], a[2], b[1]});
      add(element, {a[0], a[2], b[2], b[1]});
    }
  }

  /// A field of a mesh's elements at the nodes of the pieces.
  std::vector<Vec3> values_at(const elements::NodeNumbering& numbering, const TetMesh& mesh,
                              const std::vector<Vec3>& field) const {
    const auto& lattice = elements::tetrahedron_lattice(mesh.order);
    std::vector<Vec3> values;
    values.reserve(numbering.first_use.size());
    for (const std::int64_t use : numbering.first_use) {
      const Piece& piece = pieces_[static_cast<std::size_t>(use) / lattice.size()];
      const auto& point = lattice[static_cast<std::size_t>(use) % lattice.size()];
      Eigen::Vector4d at = Eigen::Vector4d::Zero();
      for (std::size_t i = 0; i < 4; ++i) at += point[i] * piece.corners[i].at / mesh.order;
      const Eigen::VectorXd shape = elements::tetrahedron_shape_functions(mesh.order, at, nullptr);
      const auto element = mesh.element(piece.element);
      Vec3 value = Vec3::Zero();
      for (std::size_t i = 0; i < element.size(); ++i)
        value += shape[static_cast<Eigen::Index>(i)] * field[static_cast<std::size_t>(element[i])];
      values.push_back(value);
    }
    return values;
  }

  const TetMesh& mesh_;
  std::vector<Piece> pieces_;
  std::int32_t vertices_ = 0;
  std::vector<bool> at_edge_;  ///< for each vertex
  std::set<Edge> inward_;
  std::map<Edge, Passage> passed_;             ///< sides that an inward edge passes, and how
  std::map<Edge, std::int32_t> new_vertices_;  ///< of the cut under way
};

}  // namespace

bool has_edges_to_grade(const TetMesh& mesh) {
  return !graded_edges(mesh).empty();
}

TetMesh grade_to_edges(const TetMesh& mesh, int layers) {
  if (layers <= 0) return mesh;
  Pieces pieces(mesh);
  if (!pieces.has_edges()) return mesh;
  pieces.part_edges();
  for (int layer = 0; layer < layers; ++layer) pieces.add_layer();
  return pieces.mesh();
}

}  // namespace carillon::solvers::mesh
