#include "solvers/mesh/simplify/coarser_surface.hpp"

#include <CGAL/number_utils.h>  // the next header calls is_positive() without it

#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_placement.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "solvers/mesh/simplify/cgal_mesh.hpp"
#include "solvers/mesh/simplify/cgal_optional.hpp"

namespace carillon::solvers::mesh::simplify {

namespace {

namespace collapse = CGAL::Surface_mesh_simplification;
using Point = CgalPoint;

/// Where a vertex lies: on how many edges between faces that meet at more than the crease angle.
enum class Place { face, crease, corner };

class Creases {
 public:
  Creases(const CgalMesh& mesh, double angle) : cosine_(std::cos(angle)) {
    std::map<Point, int> edges;
    for (const auto edge : mesh.edges()) {
      const auto h = mesh.halfedge(edge);
      if (!is_crease(mesh, h)) continue;
      ++edges[mesh.point(mesh.source(h))];
      ++edges[mesh.point(mesh.target(h))];
    }
    for (const auto& [point, count] : edges) {
      places_[point] = count == 2 ? Place::crease : Place::corner;
    }
  }

  bool is_crease(const CgalMesh& mesh, CgalMesh::Halfedge_index h) const {
    const auto a = normal(mesh, h), b = normal(mesh, mesh.opposite(h));
    return a * b < cosine_ * std::sqrt(a.squared_length() * b.squared_length());
  }

  Place of(const Point& point) const {
    const auto found = places_.find(point);
    return found == places_.end() ? Place::face : found->second;
  }

 private:
  static auto normal(const CgalMesh& mesh, CgalMesh::Halfedge_index h)
      -> decltype(Point() - Point()) {
    const Point &a = mesh.point(mesh.source(h)), &b = mesh.point(mesh.target(h)),
                &c = mesh.point(mesh.target(mesh.next(h)));
    return CGAL::cross_product(b - a, c - a);
  }

  double cosine_;
  std::map<Point, Place> places_;
};

/// Of the ends of an edge that may stay the one that leaves shorter edges; none where both must go
/// on.
struct OneOfItsEnds {
  const Creases* creases;

  template <class Profile>
  CgalOptional<Point> operator()(const Profile& edge) const {
    const Place from = creases->of(edge.p0()), to = creases->of(edge.p1());
    const bool along = creases->is_crease(edge.surface_mesh(), edge.v0_v1());
    const auto may_go = [&](Place place) {
      return place == Place::face || (place == Place::crease && along);
    };
    CgalOptional<Point> kept;
    if (may_go(from)) kept = edge.p1();
    if (may_go(to) && (!kept || longest(edge, edge.p0()) < longest(edge, edge.p1()))) {
      kept = edge.p0();
    }
    return kept;
  }

  /// Squared length of the longest edge that a collapse leaves at the vertex.
  template <class Profile>
  static double longest(const Profile& edge, const Point& kept) {
    double squared = 0;
    for (const auto v : edge.link()) {
      squared = std::max(squared, CGAL::squared_distance(kept, edge.surface_mesh().point(v)));
    }
    return squared;
  }
};

/// Collapses first what leaves the shortest edges, so that no vertex becomes a hub of long ones.
struct LongestEdgeLeft {
  template <class Profile>
  CgalOptional<double> operator()(const Profile& edge, const CgalOptional<Point>& kept) const {
    if (!kept) return {};
    return OneOfItsEnds::longest(edge, *kept);
  }
};

/// Stops by vertices, where CGAL counts edges: a closed surface without handles has three times as
/// many, less six.
struct SoManyVertices {
  std::size_t vertices;

  template <class Cost, class Profile>
  bool operator()(const Cost&, const Profile&, std::size_t, std::size_t edges) const {
    return edges / 3 + 2 <= vertices;
  }
};

}  // namespace

SurfaceMesh coarser_surface(const SurfaceMesh& mesh, std::size_t vertices, double crease) {
  CgalMesh work = closed_cgal_mesh(mesh);
  const Creases creases(work, crease);
  collapse::edge_collapse(
      work, SoManyVertices{vertices},
      CGAL::parameters::get_cost(LongestEdgeLeft{})
          .get_placement(collapse::Bounded_normal_change_placement<OneOfItsEnds>({&creases})));
  std::map<Point, std::int32_t> number;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    number[to_cgal(mesh.vertices[v])] = static_cast<std::int32_t>(v);
  }
  SurfaceMesh coarser = from_cgal(work);
  for (Triangle& triangle : coarser.triangles) {
    for (std::int32_t& v : triangle) {
      v = number.at(to_cgal(coarser.vertices[static_cast<std::size_t>(v)]));
    }
  }
  coarser.vertices = mesh.vertices;
  return coarser;
}

}  // namespace carillon::solvers::mesh::simplify
