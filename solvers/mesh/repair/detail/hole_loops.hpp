#pragma once

#include <cstdint>
#include <vector>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::solvers::mesh::repair {

/// A hole's border, walked so that triangles on it in the same sense close the surface.
struct HoleLoop {
  std::vector<std::int32_t> vertices;
  std::vector<std::int32_t> opposite;  ///< third corner of the triangle at edge (i, i + 1)
};

/// Simple loops of open edges. Where holes meet in a vertex they are told apart there; open edges
/// that close no loop are left out.
std::vector<HoleLoop> hole_loops(const SurfaceMesh& mesh);

/// Triangles of least area and bend that fill a loop (CGAL); none when there are none.
std::vector<Triangle> triangulate_loop(const SurfaceMesh& mesh, const HoleLoop& loop);

}  // namespace carillon::solvers::mesh::repair
