#pragma once

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::solvers::mesh::simplify {

using CgalMesh = CGAL::Surface_mesh<CGAL::Exact_predicates_inexact_constructions_kernel::Point_3>;

/// @throws InputError  the surface is open or not manifold
CgalMesh closed_cgal_mesh(const SurfaceMesh& surface);

/// Live faces and their vertices, numbered as the faces meet them.
SurfaceMesh from_cgal(const CgalMesh& mesh);

}  // namespace carillon::solvers::mesh::simplify
