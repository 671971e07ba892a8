#pragma once

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>

#include <cstddef>
#include <vector>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::solvers::mesh::simplify {

using CgalKernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using CgalPoint = CgalKernel::Point_3;
using CgalMesh = CGAL::Surface_mesh<CgalPoint>;

CgalPoint to_cgal(const Vec3& point);
Vec3 from_cgal(const CgalPoint& point);

/// Triangles as CGAL lists them where they need not bound anything.
struct CgalSoup {
  std::vector<CgalPoint> points;
  std::vector<std::vector<std::size_t>> polygons;
};
CgalSoup to_soup(const SurfaceMesh& surface);
SurfaceMesh from_cgal(const CgalSoup& soup);

/// @throws InputError  the surface is open or not manifold
CgalMesh closed_cgal_mesh(const SurfaceMesh& surface);

/// Vertices and faces that were not removed, in their order.
SurfaceMesh from_cgal(const CgalMesh& mesh);

}  // namespace carillon::solvers::mesh::simplify
