#include "solvers/mesh/simplify/cgal_mesh.hpp"

#include <CGAL/boost/graph/helpers.h>

#include "core/error.hpp"

namespace carillon::solvers::mesh::simplify {

CgalMesh closed_cgal_mesh(const SurfaceMesh& surface) {
  CgalMesh mesh;
  for (const Vec3& v : surface.vertices) mesh.add_vertex({v.x(), v.y(), v.z()});
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
  for (const auto face : mesh.faces()) {
    Triangle t{};
    std::size_t i = 0;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(face))) {
      auto& n = number[static_cast<std::size_t>(v)];
      if (n < 0) {
        n = static_cast<std::int32_t>(surface.vertices.size());
        const auto& p = mesh.point(v);
        surface.vertices.emplace_back(p.x(), p.y(), p.z());
      }
      t[i++] = n;
    }
    surface.triangles.push_back(t);
  }
  return surface;
}

}  // namespace carillon::solvers::mesh::simplify
