#include "solvers/mesh/simplify/cgal_mesh.hpp"

#include <CGAL/boost/graph/helpers.h>

#include "core/error.hpp"

namespace carillon::solvers::mesh::simplify {

CgalPoint to_cgal(const Vec3& point) {
  return {point.x(), point.y(), point.z()};
}

Vec3 from_cgal(const CgalPoint& point) {
  return {point.x(), point.y(), point.z()};
}

CgalSoup to_soup(const SurfaceMesh& surface) {
  CgalSoup soup;
  for (const Vec3& v : surface.vertices) soup.points.push_back(to_cgal(v));
  for (const Triangle& t : surface.triangles) {
    soup.polygons.push_back({static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]),
                             static_cast<std::size_t>(t[2])});
  }
  return soup;
}

SurfaceMesh from_cgal(const CgalSoup& soup) {
  SurfaceMesh surface;
  for (const CgalPoint& p : soup.points) surface.vertices.push_back(from_cgal(p));
  for (const auto& p : soup.polygons) {
    surface.triangles.push_back({static_cast<std::int32_t>(p[0]), static_cast<std::int32_t>(p[1]),
                                 static_cast<std::int32_t>(p[2])});
  }
  return surface;
}

CgalMesh closed_cgal_mesh(const SurfaceMesh& surface) {
  CgalMesh mesh;
  for (const Vec3& v : surface.vertices) mesh.add_vertex(to_cgal(v));
  for (const Triangle& t : surface.triangles) {
    const auto face = mesh.add_face(CgalMesh::Vertex_index(static_cast<unsigned>(t[0])),
                                    CgalMesh::Vertex_index(static_cast<unsigned>(t[1])),
                                    CgalMesh::Vertex_index(static_cast<unsigned>(t[2])));
    if (face == CgalMesh::null_face())
      throw core::InputError("the surface is not manifold, so it bounds no body",
                             "repair it first");
  }
  if (!CGAL::is_closed(mesh))
    throw core::InputError("the surface is open, so it bounds no body", "repair it first");
  return mesh;
}

SurfaceMesh from_cgal(const CgalMesh& mesh) {
  SurfaceMesh surface;
  std::vector<std::int32_t> number(mesh.num_vertices(), -1);
  for (const auto v : mesh.vertices()) {
    number[static_cast<std::size_t>(v)] = static_cast<std::int32_t>(surface.vertices.size());
    surface.vertices.push_back(from_cgal(mesh.point(v)));
  }
  for (const auto face : mesh.faces()) {
    Triangle t{};
    std::size_t i = 0;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(face))) {
      t[i++] = number[static_cast<std::size_t>(v)];
    }
    surface.triangles.push_back(t);
  }
  return surface;
}

}  // namespace carillon::solvers::mesh::simplify
