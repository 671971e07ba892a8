#include "solvers/remesh.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/detect_features.h>
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>

#include <cmath>
#include <numbers>

namespace carillon::solvers {
namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
using EdgeFlags = Mesh::Property_map<Mesh::Edge_index, bool>;
using VertexFlags = Mesh::Property_map<Mesh::Vertex_index, bool>;

Mesh to_cgal(const SurfaceMesh& surface) {
  Mesh mesh;
  for (const Vec3& v : surface.vertices) mesh.add_vertex({v.x(), v.y(), v.z()});
  for (const Triangle& t : surface.triangles)
    mesh.add_face(Mesh::Vertex_index(static_cast<unsigned>(t[0])),
                  Mesh::Vertex_index(static_cast<unsigned>(t[1])),
                  Mesh::Vertex_index(static_cast<unsigned>(t[2])));
  return mesh;
}

Vec3 position(const Mesh& mesh, Mesh::Vertex_index v) {
  const auto& p = mesh.point(v);
  return {p.x(), p.y(), p.z()};
}

SurfaceMesh from_cgal(Mesh& mesh) {
  mesh.collect_garbage();
  SurfaceMesh surface;
  std::vector<std::int32_t> number(mesh.number_of_vertices(), -1);
  for (const auto face : mesh.faces()) {
    Triangle t{};
    std::size_t i = 0;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(face))) {
      auto& n = number[static_cast<std::size_t>(v)];
      if (n < 0) {
        n = static_cast<std::int32_t>(surface.vertices.size());
        surface.vertices.push_back(position(mesh, v));
      }
      t[i++] = n;
    }
    surface.triangles.push_back(t);
  }
  return surface;
}

/// Vertices that must stay: where feature lines end, branch, or turn by more than 40 degrees.
void mark_corners(const Mesh& mesh, const EdgeFlags& feature, VertexFlags& corner) {
  const double straight = std::cos(feature_angle_deg * std::numbers::pi / 180);
  for (const auto v : mesh.vertices()) {
    std::vector<Vec3> ways;
    for (const auto h : CGAL::halfedges_around_target(v, mesh))
      if (feature[mesh.edge(h)])
        ways.push_back((position(mesh, mesh.source(h)) - position(mesh, v)).normalized());
    corner[v] = !ways.empty() && (ways.size() != 2 || -ways[0].dot(ways[1]) < straight);
  }
}

/// Faces whose middle may have edges of `size`, less those next to a face that may not.
std::vector<Mesh::Face_index> faces_that_allow(
    const Mesh& mesh, double size, const std::function<double(const Vec3&)>& wanted_size) {
  std::vector<bool> allowed(mesh.num_faces(), false);
  for (const auto face : mesh.faces()) {
    Vec3 middle = Vec3::Zero();
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(face)))
      middle += position(mesh, v) / 3;
    allowed[static_cast<std::size_t>(face)] = wanted_size(middle) >= size;
  }
  std::vector<Mesh::Face_index> faces;
  for (const auto face : mesh.faces()) {
    bool inside = allowed[static_cast<std::size_t>(face)];
    for (const auto h : CGAL::halfedges_around_face(mesh.halfedge(face), mesh))
      inside = inside && allowed[static_cast<std::size_t>(mesh.face(mesh.opposite(h)))];
    if (inside) faces.push_back(face);
  }
  return faces;
}

}  // namespace

SurfaceMesh remesh(const SurfaceMesh& surface, double coarsest, int levels,
                   const std::function<double(const Vec3&)>& wanted_size) {
  Mesh mesh = to_cgal(surface);
  auto feature = mesh.add_property_map<Mesh::Edge_index, bool>("e:feature", false).first;
  auto corner = mesh.add_property_map<Mesh::Vertex_index, bool>("v:corner", false).first;
  pmp::detect_sharp_edges(mesh, feature_angle_deg, feature);
  mark_corners(mesh, feature, corner);

  // From fine to coarse: feature lines keep their vertices when edges collapse, so that none is
  // ever a chord of a coarser one.
  for (int level = levels; level >= 0; --level) {
    const double size = coarsest / std::pow(2, level);
    mesh.collect_garbage();
    std::vector<Mesh::Face_index> faces(mesh.faces().begin(), mesh.faces().end());
    if (level < levels) faces = faces_that_allow(mesh, 0.8 * size, wanted_size);
    if (faces.empty()) break;
    pmp::isotropic_remeshing(faces, size, mesh,
                             pmp::parameters::number_of_iterations(4)
                                 .number_of_relaxation_steps(2)
                                 .edge_is_constrained_map(feature)
                                 .vertex_is_constrained_map(corner)
                                 .collapse_constraints(true)
                                 .relax_constraints(false)
                                 .protect_constraints(false));
  }
  return from_cgal(mesh);
}

bool intersects_itself(const SurfaceMesh& surface) {
  const Mesh mesh = to_cgal(surface);
  if (mesh.number_of_faces() != surface.triangles.size()) return true;  // not manifold
  return pmp::does_self_intersect(mesh);
}

}  // namespace carillon::solvers
