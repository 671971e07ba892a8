#include "solvers/mesh/tetrahedra/detail/remesh.hpp"

#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/boost/graph/Euler_operations.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <numbers>

#include "solvers/mesh/simplify/cgal_mesh.hpp"
#include "solvers/mesh/tetrahedra/detail/feature_lines.hpp"

namespace carillon::solvers::mesh::tetrahedra {
namespace {

using Vertex = simplify::CgalMesh::Vertex_index;
using Halfedge = simplify::CgalMesh::Halfedge_index;
using Edge = simplify::CgalMesh::Edge_index;

/// Edges are split above this multiple of the wanted size and collapsed below the other.
constexpr double too_long = 4.0 / 3, too_short = 4.0 / 5;
constexpr int rounds = 6;
/// An edge below this multiple is in the way even of features, as long as no more volume than this
/// multiple of the wanted size cubed goes with it: noise of a scan does, the end of a slot does
/// not.
constexpr double tiny = 0.1, tiny_volume = 1e-4;
/// Triangles of a thinness() below this only come in the place of thinner ones.
constexpr double thin = 0.05;
/// Feature lines that end somewhere are noise of a scan below this many edges, not design.
constexpr double shortest_line = 3;

enum class Kind : char { free, line, corner, fixed };

class Remesher {
 public:
  Remesher(const SurfaceMesh& surface, const std::vector<double>& sizes,
           const std::vector<bool>& fixed, const SurfaceSearch& search)
      : surface_(surface),
        sizes_(sizes),
        search_(search),
        mesh_(simplify::closed_cgal_mesh(surface)) {
    feature_ = mesh_.add_property_map<Edge, bool>("e:feature", false).first;
    kind_ = mesh_.add_property_map<Vertex, Kind>("v:kind", Kind::free).first;
    size_ = mesh_.add_property_map<Vertex, double>("v:size", 0).first;
    for (const Vertex v : mesh_.vertices()) size_[v] = sizes[static_cast<std::size_t>(v)];
    mark_features();
    for (const Vertex v : mesh_.vertices())
      if (fixed[static_cast<std::size_t>(v)]) kind_[v] = Kind::fixed;
  }

  SurfaceMesh run() {
    for (int round = 0; round < rounds; ++round) {
      split_long_edges();
      collapse_short_edges();
      flip_edges();
      relax();
      relax();
    }
    return simplify::from_cgal(mesh_);
  }

 private:
  bool is_fixed(Edge e) const {
    return kind_[mesh_.vertex(e, 0)] == Kind::fixed && kind_[mesh_.vertex(e, 1)] == Kind::fixed;
  }
  Vec3 at(Vertex v) const { return simplify::from_cgal(mesh_.point(v)); }
  void move(Vertex v, const Vec3& p) { mesh_.point(v) = simplify::to_cgal(p); }
  double length(Edge e) const { return (at(mesh_.vertex(e, 0)) - at(mesh_.vertex(e, 1))).norm(); }
  double wanted(Edge e) const {
    return std::min(size_[mesh_.vertex(e, 0)], size_[mesh_.vertex(e, 1)]);
  }
  /// Twice the area vector of the face left of a half-edge.
  Vec3 face_vector(Halfedge h) const {
    const Vec3 a = at(mesh_.source(h)), b = at(mesh_.target(h));
    return (b - a).cross(at(mesh_.target(mesh_.next(h))) - a);
  }
  std::vector<Edge> live_edges() const { return {mesh_.edges().begin(), mesh_.edges().end()}; }

  void mark_features() {
    const double angle = feature_angle_deg * std::numbers::pi / 180;
    for (const Edge e : mesh_.edges()) {
      const Vec3 a = face_vector(mesh_.halfedge(e, 0)), b = face_vector(mesh_.halfedge(e, 1));
      feature_[e] = angle_between(a, b) > angle;
    }
    drop_short_lines();
    for (const Vertex v : mesh_.vertices()) {
      std::vector<Vec3> ways;
      for (const Halfedge h : mesh_.halfedges_around_target(mesh_.halfedge(v)))
        if (feature_[mesh_.edge(h)]) ways.push_back((at(mesh_.source(h)) - at(v)).normalized());
      if (ways.empty()) continue;
      const bool smooth = ways.size() == 2 && -ways[0].dot(ways[1]) > std::cos(angle);
      kind_[v] = smooth ? Kind::line : Kind::corner;
    }
  }

  int feature_edges_at(Vertex v) const {
    int count = 0;
    for (const Halfedge h : mesh_.halfedges_around_target(mesh_.halfedge(v)))
      count += feature_[mesh_.edge(h)] ? 1 : 0;
    return count;
  }

  void drop_short_lines() {
    std::vector<bool> seen(mesh_.num_edges(), false);
    for (const Edge start : mesh_.edges()) {
      if (!feature_[start] || seen[static_cast<std::size_t>(start)]) continue;
      std::vector<Edge> line{start};
      seen[static_cast<std::size_t>(start)] = true;
      double total = 0;
      bool ends = false;
      for (std::size_t i = 0; i < line.size(); ++i) {
        total += length(line[i]) / wanted(line[i]);
        for (unsigned end : {0u, 1u}) {
          const Vertex v = mesh_.vertex(line[i], end);
          ends = ends || feature_edges_at(v) == 1;
          for (const Halfedge h : mesh_.halfedges_around_target(mesh_.halfedge(v))) {
            const Edge e = mesh_.edge(h);
            if (!feature_[e] || seen[static_cast<std::size_t>(e)]) continue;
            seen[static_cast<std::size_t>(e)] = true;
            line.push_back(e);
          }
        }
      }
      if (ends && total < shortest_line)
        for (const Edge e : line) feature_[e] = false;
    }
  }

  void split_long_edges() {
    auto edges = live_edges();
    std::stable_sort(edges.begin(), edges.end(),
                     [&](Edge a, Edge b) { return length(a) > length(b); });
    for (std::size_t i = 0; i < edges.size(); ++i) {
      const Edge e = edges[i];
      if (is_fixed(e) || length(e) <= too_long * wanted(e)) continue;
      const bool was_feature = feature_[e];
      const Halfedge h = mesh_.halfedge(e);
      const Vertex a = mesh_.source(h), b = mesh_.target(h);
      const Vec3 middle = 0.5 * (at(a) + at(b));
      const double size = 0.5 * (size_[a] + size_[b]);
      const Halfedge first = CGAL::Euler::split_edge(h, mesh_);  // a to the new vertex
      const Vertex v = mesh_.target(first);
      move(v, middle);
      size_[v] = size;
      kind_[v] = was_feature ? Kind::line : Kind::free;
      const Halfedge second = mesh_.next(first);
      feature_[mesh_.edge(first)] = feature_[mesh_.edge(second)] = was_feature;
      const Halfedge left = CGAL::Euler::split_face(first, mesh_.next(second), mesh_);
      const Halfedge back = mesh_.opposite(second);
      const Halfedge right = CGAL::Euler::split_face(back, mesh_.next(mesh_.next(back)), mesh_);
      feature_[mesh_.edge(left)] = feature_[mesh_.edge(right)] = false;
      for (const Edge part :
           {mesh_.edge(first), mesh_.edge(second), mesh_.edge(left), mesh_.edge(right)})
        edges.push_back(part);
    }
  }

  /// Whether `gone` may slide along the half-edge to its target.
  bool may_collapse(Halfedge h) const {
    const Vertex gone = mesh_.source(h), kept = mesh_.target(h);
    if (kind_[gone] == Kind::fixed || kind_[gone] > kind_[kept]) return false;
    const bool leaves_line = kind_[gone] == Kind::line && !feature_[mesh_.edge(h)];
    if (kind_[gone] == Kind::corner || leaves_line) {
      const double size = wanted(mesh_.edge(h));
      if (length(mesh_.edge(h)) > tiny * size) return false;
      if (std::abs(volume_swept(h)) > tiny_volume * std::pow(size, 3)) return false;
    }
    // Two feature edges of one triangle would fall together.
    for (const Halfedge side : {h, mesh_.opposite(h)})
      if (feature_[mesh_.edge(mesh_.next(side))] && feature_[mesh_.edge(mesh_.prev(side))])
        return false;
    double thinnest = thin;
    for (const Halfedge around : mesh_.halfedges_around_target(mesh_.halfedge(gone)))
      thinnest = std::min(thinnest, thinness(at(gone), at(mesh_.source(around)),
                                             at(mesh_.target(mesh_.next(around)))));
    for (const Halfedge around : mesh_.halfedges_around_target(mesh_.halfedge(gone))) {
      const Vertex neighbour = mesh_.source(around);
      if (neighbour == kept) continue;
      const double stretched = (at(neighbour) - at(kept)).norm();
      if (stretched > too_long * std::min(size_[neighbour], size_[kept])) return false;
      // The face left of `around` keeps its corners but for `gone`.
      const Vertex third = mesh_.target(mesh_.next(around));
      if (third == kept || neighbour == kept) continue;
      const Vec3 before = face_vector(around);
      const Vec3 after = (at(kept) - at(neighbour)).cross(at(third) - at(neighbour));
      if (after.dot(before) < 0.7 * after.norm() * before.norm()) return false;
      if (thinness(at(kept), at(neighbour), at(third)) < thinnest) return false;
    }
    return CGAL::Euler::does_satisfy_link_condition(mesh_.edge(h), mesh_);
  }

  /// Volume that the surface gains when the source of a half-edge goes to its target.
  double volume_swept(Halfedge h) const {
    const Vertex gone = mesh_.source(h);
    const Vec3 way = at(mesh_.target(h)) - at(gone);
    double sum = 0;
    for (const Halfedge around : mesh_.halfedges_around_target(mesh_.halfedge(gone)))
      sum += way.dot((at(mesh_.source(around)) - at(gone))
                         .cross(at(mesh_.target(mesh_.next(around))) - at(gone)));
    return sum / 6;
  }

  /// Twice the area over the longest edge squared: 0.87 equilateral, 0 flat.
  static double thinness(const Vec3& a, const Vec3& b, const Vec3& c) {
    const double longest =
        std::max({(a - b).squaredNorm(), (b - c).squaredNorm(), (c - a).squaredNorm()});
    return longest > 0 ? (b - a).cross(c - a).norm() / longest : 0;
  }

  void collapse_short_edges() {
    auto edges = live_edges();
    std::stable_sort(edges.begin(), edges.end(),
                     [&](Edge a, Edge b) { return length(a) < length(b); });
    for (const Edge e : edges) {
      if (mesh_.is_removed(e) || length(e) >= too_short * wanted(e)) continue;
      for (const Halfedge h : {mesh_.halfedge(e, 0), mesh_.halfedge(e, 1)}) {
        if (!may_collapse(h)) continue;
        const Vertex kept = mesh_.target(h);
        const Vec3 place = at(kept);
        const double size = size_[kept];
        const Kind kind = std::max(kind_[kept], kind_[mesh_.source(h)]);
        feature_[e] = false;  // what goes away is not constrained
        const Vertex left = CGAL::Euler::collapse_edge(e, mesh_, feature_);
        move(left, place);
        size_[left] = size;
        kind_[left] = kind;
        break;
      }
    }
  }

  int wanted_neighbours(Vertex v) const { return kind_[v] == Kind::free ? 6 : 5; }

  void flip_edges() {
    for (const Edge e : live_edges()) {
      if (feature_[e] || is_fixed(e)) continue;
      const Halfedge h = mesh_.halfedge(e), o = mesh_.opposite(h);
      const Vertex a = mesh_.source(h), b = mesh_.target(h);
      const Vertex c = mesh_.target(mesh_.next(h)), d = mesh_.target(mesh_.next(o));
      if (c == d || mesh_.halfedge(c, d) != simplify::CgalMesh::null_halfedge()) continue;
      const auto excess = [&](Vertex v, int change) {
        return std::abs(static_cast<int>(mesh_.degree(v)) + change - wanted_neighbours(v));
      };
      const int now = excess(a, 0) + excess(b, 0) + excess(c, 0) + excess(d, 0);
      const int then = excess(a, -1) + excess(b, -1) + excess(c, 1) + excess(d, 1);
      const double flattest = flattest_pair(at(a), at(b), at(c), at(d));
      const double flattest_then = flattest_pair(at(c), at(d), at(b), at(a));
      // Better counts unless shapes suffer, or much better shapes whatever the counts.
      const bool better =
          (then < now && flattest_then > 0.3) || (flattest < 0.3 && flattest_then > 1.5 * flattest);
      if (!better) continue;
      const Vec3 old_sum = face_vector(h) + face_vector(o);
      const Vec3 n1 = (at(d) - at(c)).cross(at(b) - at(c));
      const Vec3 n2 = (at(a) - at(c)).cross(at(d) - at(c));
      // Both new faces look the way the old ones did, and neither folds against the other.
      const auto agrees = [](const Vec3& p, const Vec3& q) {
        return p.dot(q) > 0.85 * p.norm() * q.norm();
      };
      if (!agrees(n1, old_sum) || !agrees(n2, old_sum)) continue;
      CGAL::Euler::flip_edge(h, mesh_);
    }
  }

  /// Shape of the worse of the triangles abc and bad: 1 equilateral, 0 flat.
  static double flattest_pair(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    const auto shape = [](const Vec3& p, const Vec3& q, const Vec3& r) {
      const double sum = (p - q).squaredNorm() + (q - r).squaredNorm() + (r - p).squaredNorm();
      return sum > 0 ? 2 * std::sqrt(3.0) * (q - p).cross(r - p).norm() / sum : 0;
    };
    return std::min(shape(a, b, c), shape(b, a, d));
  }

  /// Free vertices to the middle of their neighbours, along the surface, then on to it.
  void relax() {
    for (const Vertex v : mesh_.vertices()) {
      if (kind_[v] != Kind::free) continue;
      Vec3 normal = Vec3::Zero(), middle = Vec3::Zero();
      double weights = 0, nearest = std::numeric_limits<double>::infinity();
      for (const Halfedge h : mesh_.halfedges_around_target(mesh_.halfedge(v))) {
        const Vec3 area = face_vector(h), other = at(mesh_.source(h));
        normal += area;
        // Vertices crowd where sizes are small: weight by area over size to the fourth.
        const double size =
            (size_[mesh_.source(h)] + size_[mesh_.target(mesh_.next(h))] + size_[v]) / 3;
        const double weight = area.norm() / std::pow(size, 4);
        middle += weight * (other + at(mesh_.target(mesh_.next(h))) + at(v)) / 3;
        weights += weight;
        nearest = std::min(nearest, (other - at(v)).norm());
      }
      if (!(weights > 0) || !(normal.norm() > 0)) continue;
      normal.normalize();
      Vec3 step = middle / weights - at(v);
      step -= normal.dot(step) * normal;
      const Vec3 from = at(v);
      const auto hit = search_.nearest_on_side(from + step, normal);
      if (!hit || (hit->point - from).norm() > 2 * size_[v] || folds(v, hit->point)) continue;
      move(v, hit->point);
      size_[v] = size_on(*hit);
    }
  }

  /// Whether a face around v would turn over, or nearly, with v at p.
  bool folds(Vertex v, const Vec3& p) const {
    for (const Halfedge h : mesh_.halfedges_around_target(mesh_.halfedge(v))) {
      const Vec3 before = face_vector(h);
      const Vec3 a = at(mesh_.source(h)), c = at(mesh_.target(mesh_.next(h)));
      const Vec3 after = (p - a).cross(c - a);
      if (after.dot(before) < 0.7 * after.norm() * before.norm()) return true;
      if (thinness(p, a, c) < std::min(thin, thinness(at(v), a, c))) return true;
    }
    return false;
  }

  double size_on(const SurfaceSearch::Hit& hit) const {
    const Triangle& t = surface_.triangles[hit.triangle];
    double sum = 0, weights = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      // Barycentric coordinates by areas.
      const Vec3 b = surface_.vertices[static_cast<std::size_t>(t[(i + 1) % 3])] - hit.point;
      const Vec3 c = surface_.vertices[static_cast<std::size_t>(t[(i + 2) % 3])] - hit.point;
      const double weight = b.cross(c).norm();
      sum += weight * sizes_[static_cast<std::size_t>(t[i])];
      weights += weight;
    }
    return weights > 0 ? sum / weights : sizes_[static_cast<std::size_t>(t[0])];
  }

  const SurfaceMesh& surface_;
  const std::vector<double>& sizes_;
  const SurfaceSearch& search_;
  simplify::CgalMesh mesh_;
  simplify::CgalMesh::Property_map<Edge, bool> feature_;
  simplify::CgalMesh::Property_map<Vertex, Kind> kind_;
  simplify::CgalMesh::Property_map<Vertex, double> size_;
};

}  // namespace

SurfaceMesh remesh(const SurfaceMesh& surface, const std::vector<double>& sizes,
                   const std::vector<bool>& fixed, const SurfaceSearch& search) {
  return Remesher(surface, sizes, fixed, search).run();
}

std::vector<std::pair<std::size_t, std::size_t>> crossings(const SurfaceMesh& surface) {
  const simplify::CgalMesh mesh = simplify::closed_cgal_mesh(surface);
  std::vector<std::pair<simplify::CgalMesh::Face_index, simplify::CgalMesh::Face_index>> found;
  CGAL::Polygon_mesh_processing::self_intersections(mesh, std::back_inserter(found));
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (const auto& [a, b] : found) pairs.emplace_back(a, b);
  return pairs;
}

std::optional<SurfaceMesh> remesh_apart(const SurfaceMesh& surface, const SizeField& field,
                                        double coarsest, double relax,
                                        const SurfaceSearch& search) {
  constexpr int tries = 8;
  constexpr int halvings = 2;
  const std::vector<double> wanted = vertex_sizes(surface, field, coarsest, relax);
  std::vector<double> sizes = wanted;
  std::vector<bool> fixed(sizes.size(), false);
  std::vector<int> halved(sizes.size(), 0);
  for (int attempt = 0; attempt < tries; ++attempt) {
    SurfaceMesh fitted = remesh(surface, sizes, fixed, search);
    const auto pairs = crossings(fitted);
    if (pairs.empty()) return fitted;
    // Every vertex as near to a crossing triangle's middle as twice its corners are.
    std::vector<bool> near(sizes.size(), false);
    for (const auto& [a, b] : pairs)
      for (const std::size_t t : {a, b}) {
        const auto corner = [&](std::size_t i) {
          return fitted.vertices[static_cast<std::size_t>(fitted.triangles[t][i])];
        };
        const Vec3 middle = (corner(0) + corner(1) + corner(2)) / 3;
        double reach = 0;
        for (std::size_t i = 0; i < 3; ++i)
          reach = std::max(reach, 4 * (corner(i) - middle).squaredNorm());
        for (std::size_t v = 0; v < near.size(); ++v)
          near[v] = near[v] || (surface.vertices[v] - middle).squaredNorm() <= reach;
      }
    bool changed = false;
    for (std::size_t v = 0; v < near.size(); ++v) {
      if (near[v] && !fixed[v]) {
        changed = true;
        fixed[v] = ++halved[v] > halvings;
      }
      sizes[v] = fixed[v] ? wanted[v] : std::ldexp(wanted[v], -halved[v]);
    }
    if (!changed) break;
    limit_growth(surface, sizes);
  }
  return std::nullopt;
}

}  // namespace carillon::solvers::mesh::tetrahedra
