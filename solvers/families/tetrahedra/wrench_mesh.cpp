#include <fmt/format.h>
#include <gmsh.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "solvers/families/extrude.hpp"
#include "solvers/families/family.hpp"
#include "solvers/mesh/mirrored_part.hpp"
#include "solvers/mesh/sizing.hpp"
#include "solvers/mesh/tetrahedra/delaunay.hpp"

namespace carillon::solvers::families {
namespace {

constexpr double pi = std::numbers::pi;

/// A piece of an outline: a line, or an arc about a centre (turning left when angle > 0).
struct OutlinePiece {
  Vec2 from, to;
  std::optional<Vec2> centre;
  double angle = 0;  ///< [rad], signed

  double length() const {
    return centre ? std::abs(angle) * (from - *centre).norm() : (to - from).norm();
  }
  Vec2 point(double u) const {
    if (!centre) return (1 - u) * from + u * to;
    return *centre + Eigen::Rotation2Dd(u * angle) * (from - *centre);
  }
  /// The u of a point of the piece.
  double coordinate(const Vec2& p) const {
    if (!centre) return (p - from).dot(to - from) / (to - from).squaredNorm();
    const Vec2 a = from - *centre, b = p - *centre;
    return std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b)) / angle;
  }
};

void add_line(std::vector<OutlinePiece>& outline, const Vec2& to) {
  const Vec2 from = outline.back().to;
  outline.push_back({from, to, {}, 0});
}

/// Arc on from the last piece; cut into parts of less than half a turn, as Gmsh wants them.
void add_arc(std::vector<OutlinePiece>& outline, const Vec2& centre, double angle) {
  const Vec2 first = outline.back().to;
  const int parts = std::max(1, static_cast<int>(std::ceil(std::abs(angle) / (0.6 * pi))));
  for (int k = 0; k < parts; ++k) {
    const auto at = [&](int i) -> Vec2 {
      return centre + Eigen::Rotation2Dd(angle * i / parts) * (first - centre);
    };
    outline.push_back({at(k), at(k + 1), centre, angle / parts});
  }
}

/// Outline of the half above y = 0, counter-clockwise: a round head about the origin with a jaw
/// slot that opens to +x and ends in a half circle, a fillet where the handle meets the head, a
/// handle along -x with a round end.
std::vector<OutlinePiece> wrench_outline(const mesh::GeneratedShape& shape) {
  const double head = parameter(shape, "head_radius");
  const double jaw = parameter(shape, "jaw_width") / 2;
  const double handle = parameter(shape, "handle_width") / 2;
  const double end = parameter(shape, "length") - head - handle;  // centre of the round end
  const double fillet = 0.5 * head;
  const Vec2 fillet_centre(-std::sqrt(std::pow(head + fillet, 2) - std::pow(handle + fillet, 2)),
                           handle + fillet);
  const Vec2 touch = fillet_centre * head / (head + fillet);  // where fillet and head meet
  const Vec2 tip(std::sqrt(head * head - jaw * jaw), jaw);
  const auto angle_of = [](const Vec2& p) { return std::atan2(p.y(), p.x()); };
  const double head_angle = angle_of(touch) - angle_of(tip);
  const double fillet_angle = -(angle_of(-touch) + pi / 2);

  std::vector<OutlinePiece> outline;
  outline.push_back({Vec2(0, jaw), tip, {}, 0});
  add_arc(outline, Vec2::Zero(), head_angle);
  add_arc(outline, fillet_centre, -std::abs(fillet_angle));
  add_line(outline, {-end, handle});
  add_arc(outline, Vec2(-end, 0), pi / 2);
  outline.back().to.y() = 0;
  add_line(outline, {-jaw, 0});
  add_arc(outline, Vec2::Zero(), -pi / 2);
  outline.back().to = outline.front().from;
  return outline;
}

/// Signed area inside the outline.
double enclosed_area(const std::vector<OutlinePiece>& outline) {
  double twice = 0;
  for (const auto& piece : outline) {
    twice += piece.from.x() * piece.to.y() - piece.from.y() * piece.to.x();
    if (piece.centre)
      twice += (piece.from - *piece.centre).squaredNorm() * (piece.angle - std::sin(piece.angle));
  }
  return twice / 2;
}

using Triangle = std::array<std::int32_t, 3>;
using Edge = std::pair<std::int32_t, std::int32_t>;

/// Edges of a triangulated region along its outline: which piece each is of.
struct OutlineEdges {
  const std::vector<OutlinePiece>& outline;
  const std::vector<Vec2>& points;
  std::map<Edge, std::size_t> piece;

  /// Where an edge begins at one of its ends; nothing inside the region.
  std::optional<Vec2> direction(std::int32_t from, std::int32_t to) const {
    const auto found = piece.find(std::minmax(from, to));
    if (found == piece.end()) return std::nullopt;
    const auto& own = outline[found->second];
    const Vec2& start = points[static_cast<std::size_t>(from)];
    const double u = own.coordinate(start);
    const double along = own.coordinate(points[static_cast<std::size_t>(to)]) - u;
    return (own.point(u + 1e-4 * along) - own.point(u)).normalized();
  }

  /// The corner of a triangle between two edges that go on into one another, if there is one: with
  /// curved edges it is flat.
  std::optional<std::size_t> flat_corner(const Triangle& triangle) const {
    constexpr double flat = -0.9;  // cosine
    for (std::size_t i = 0; i < 3; ++i) {
      const auto one = direction(triangle[i], triangle[(i + 1) % 3]);
      const auto other = direction(triangle[i], triangle[(i + 2) % 3]);
      if (one && other && one->dot(*other) < flat) return i;
    }
    return std::nullopt;
  }
};

/// Parts flat corners by flipping the edges opposite to them: coarse triangles have all three
/// corners on one arc where the region is narrow.
class CornerParting {
 public:
  CornerParting(const OutlineEdges& edges, std::vector<Triangle>& triangles)
      : edges_(edges), triangles_(triangles) {}

  void run() {
    // An arc's triangles may hang on one another, one flip making room for the next.
    constexpr int max_passes = 12;
    bool changed = true;
    for (int pass = 0; changed && pass < max_passes; ++pass) {
      changed = false;
      for (std::size_t t = 0; t < triangles_.size(); ++t) {
        if (const auto corner = edges_.flat_corner(triangles_[t]))
          changed = flip(t, *corner) || flip_beyond(t, *corner) || changed;
      }
    }
  }

 private:
  double area(const Triangle& t) const {
    const auto at = [&](std::size_t i) { return edges_.points[static_cast<std::size_t>(t[i])]; };
    const Vec2 a = at(1) - at(0), b = at(2) - at(0);
    return a.x() * b.y() - a.y() * b.x();
  }

  /// The triangle beside another one, opposite to a corner, and its corner there.
  std::optional<std::pair<std::size_t, std::size_t>> beside(std::size_t t,
                                                            std::size_t corner) const {
    const auto from = triangles_[t][(corner + 1) % 3], to = triangles_[t][(corner + 2) % 3];
    for (std::size_t other = 0; other < triangles_.size(); ++other)
      for (std::size_t i = 0; i < 3; ++i)
        if (triangles_[other][(i + 1) % 3] == to && triangles_[other][(i + 2) % 3] == from)
          return std::pair(other, i);
    return std::nullopt;
  }

  /// Flips the edge opposite to a corner unless that leaves another flat corner or next to no area.
  bool flip(std::size_t t, std::size_t corner) {
    constexpr double min_share = 0.05;
    const auto other = beside(t, corner);
    if (!other) return false;
    const auto at = triangles_[t][corner], across = triangles_[other->first][other->second];
    const Triangle one = {at, triangles_[t][(corner + 1) % 3], across};
    const Triangle two = {at, across, triangles_[t][(corner + 2) % 3]};
    const double enough = min_share * (area(one) + area(two));
    if (area(one) < enough || area(two) < enough || edges_.flat_corner(one) ||
        edges_.flat_corner(two))
      return false;
    triangles_[t] = one;
    triangles_[other->first] = two;
    return true;
  }

  /// Flips another edge of the triangle opposite to a corner.
  bool flip_beyond(std::size_t t, std::size_t corner) {
    const auto other = beside(t, corner);
    if (!other) return false;
    const auto [neighbour, own] = *other;
    return flip(neighbour, (own + 1) % 3) || flip(neighbour, (own + 2) % 3);
  }

  const OutlineEdges& edges_;
  std::vector<Triangle>& triangles_;
};

/// Triangles of the region with edges of about `cell`, curved edges by the pieces' formulas.
PlanarGrid triangulate(const std::vector<OutlinePiece>& outline, double cell) {
  PlanarGrid grid;
  std::vector<Vec2> points;
  std::map<Edge, std::size_t> piece_of_edge;
  mesh::tetrahedra::with_gmsh("triangles of an outline", [&] {
    mesh::tetrahedra::GmshModel model;
    std::vector<int> corners, curves;
    for (const auto& piece : outline)
      corners.push_back(gmsh::model::geo::addPoint(piece.from.x(), piece.from.y(), 0, cell));
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const auto& piece = outline[i];
      const int a = corners[i], b = corners[(i + 1) % corners.size()];
      if (piece.centre)
        curves.push_back(gmsh::model::geo::addCircleArc(
            a, gmsh::model::geo::addPoint(piece.centre->x(), piece.centre->y(), 0, cell), b));
      else
        curves.push_back(gmsh::model::geo::addLine(a, b));
    }
    const int surface = gmsh::model::geo::addPlaneSurface({gmsh::model::geo::addCurveLoop(curves)});
    gmsh::model::geo::synchronize();
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const int bends = static_cast<int>(
          std::ceil(std::abs(outline[i].angle) / mesh::max_element_angle * (1 - 1e-9)));
      gmsh::model::mesh::setTransfiniteCurve(
          curves[i], 1 + std::max(bends, mesh::cells_along(outline[i].length(), cell)));
    }
    gmsh::option::setNumber("Mesh.Algorithm", 6);  // frontal Delaunay
    gmsh::option::setNumber("Mesh.MeshSizeExtendFromBoundary", 1);
    gmsh::option::setNumber("Mesh.MeshSizeFromPoints", 1);
    gmsh::model::mesh::generate(2);

    std::map<std::size_t, std::int32_t> number;
    const auto vertex = [&](std::size_t tag) {
      const auto [entry, is_new] =
          number.try_emplace(tag, static_cast<std::int32_t>(points.size()));
      if (is_new) points.emplace_back(mesh::tetrahedra::gmsh_node(tag).head<2>());
      return entry->second;
    };
    // Fresh vectors for each call: Gmsh leaves those that are not empty as they are.
    const auto nodes_of = [](int type, int entity) {
      std::vector<std::size_t> elements, nodes;
      gmsh::model::mesh::getElementsByType(type, elements, nodes, entity);
      return nodes;
    };
    const auto corner_nodes = nodes_of(2, surface);
    for (std::size_t n = 0; n < corner_nodes.size(); n += 3)
      grid.triangles.push_back(
          {vertex(corner_nodes[n]), vertex(corner_nodes[n + 1]), vertex(corner_nodes[n + 2])});
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const auto edge_nodes = nodes_of(1, curves[i]);
      for (std::size_t n = 0; n < edge_nodes.size(); n += 2)
        piece_of_edge[std::minmax(vertex(edge_nodes[n]), vertex(edge_nodes[n + 1]))] = i;
    }
  });
  grid.vertices = static_cast<std::int32_t>(points.size());

  // Gmsh's arcs are right to its tolerance; ours to rounding.
  for (const auto& [edge, piece] : piece_of_edge)
    for (std::int32_t v : {edge.first, edge.second}) {
      auto& p = points[static_cast<std::size_t>(v)];
      p = outline[piece].point(std::clamp(outline[piece].coordinate(p), 0.0, 1.0));
    }
  const OutlineEdges edges = {outline, points, piece_of_edge};
  CornerParting(edges, grid.triangles).run();
  const auto triangles = grid.triangles;
  grid.point = [=](std::size_t t, const Eigen::Vector3d& b) -> Vec2 {
    const auto& corner = triangles[t];
    const auto at = [&](std::size_t i) { return points[static_cast<std::size_t>(corner[i])]; };
    Vec2 p = b[0] * at(0) + b[1] * at(1) + b[2] * at(2);
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3;
      const auto found = piece_of_edge.find(std::minmax(corner[i], corner[j]));
      if (found == piece_of_edge.end() || !outline[found->second].centre) continue;
      const double bi = b[static_cast<Eigen::Index>(i)], bj = b[static_cast<Eigen::Index>(j)];
      if (bi <= 0 || bj <= 0) continue;
      // Arc minus chord along the edge, faded out towards the opposite corner (Szabo, Babuska).
      const auto& piece = outline[found->second];
      const double t_edge = 0.5 * (1 + bj - bi);
      const double u = (1 - t_edge) * piece.coordinate(at(i)) + t_edge * piece.coordinate(at(j));
      const Vec2 bow = piece.point(u) - ((1 - t_edge) * at(i) + t_edge * at(j));
      p += bi * bj / (t_edge * (1 - t_edge)) * bow;
    }
    return p;
  };
  return grid;
}

}  // namespace

mesh::MeshResult mesh_wrench(const mesh::GeneratedShape& shape, const mesh::MeshOptions& options) {
  find_family("wrench").check(shape);
  const auto outline = wrench_outline(shape);
  const double thickness = parameter(shape, "thickness");
  double perimeter = 0;
  for (const auto& piece : outline) perimeter += piece.length();
  const auto layers_of = [&](double cell) {
    return even_cells(mesh::layers_through(thickness, cell, options));
  };
  // Equilateral triangles of the area, and those the outline adds.
  const auto count = [&](double cell) {
    const double triangles = 2.31 * enclosed_area(outline) / (cell * cell) + perimeter / cell + 20;
    return static_cast<std::int64_t>(3 * 2 * triangles) * layers_of(cell);
  };
  const double cell = mesh::cell_size(options, thickness, parameter(shape, "length"), count);
  const std::vector<mesh::MirrorPlane> planes = {{1, 0}};
  return finish(mesh::symmetrised(mesh::unfold(
      extrude(triangulate(outline, cell), layers_of(cell), options.order,
              [thickness](const Vec2& p, double t) { return Vec3(p.x(), p.y(), t * thickness); }),
      planes)));
}

}  // namespace carillon::solvers::families
