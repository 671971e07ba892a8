#pragma once

#include <functional>
#include <string>

#include "solvers/mesh/tet_mesh.hpp"

namespace carillon::solvers::mesh::tetrahedra {

/// Fills closed surfaces by boundary-constrained Delaunay (Gmsh's library, one thread): every
/// triangle becomes a boundary face (but for flat elements on it, which are peeled off), sizes
/// inside follow those of the surface (edges deep in a solid reach 1.7 times the surface's). First
/// order.
/// @param surface  clean; each component that looks outward becomes a body, those that look inward
///                 are cavities of the body around them
/// @throws SolverError  with Gmsh's reason
TetMesh fill_with_tetrahedra(const SurfaceMesh& surface);

/// One model in Gmsh's library, silent, one thread, its own files ignored. The library starts and
/// ends with the object: its global state would let a mesh depend on the one before.
class GmshModel {
 public:
  GmshModel();
  ~GmshModel();
  GmshModel(const GmshModel&) = delete;
  GmshModel& operator=(const GmshModel&) = delete;
};

/// Runs calls of Gmsh and turns what it throws or reports into a SolverError that begins with
/// `what`.
void with_gmsh(const std::string& what, const std::function<void()>& calls);

/// Where a node of Gmsh's mesh lies. Called within with_gmsh().
Vec3 gmsh_node(std::size_t tag);

}  // namespace carillon::solvers::mesh::tetrahedra
