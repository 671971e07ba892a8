#pragma once

#include "solvers/mesh/shape_source.hpp"

namespace carillon::solvers::mesh::repair {

/// What is right and wrong with a surface (CGAL).
Diagnosis diagnose(const SurfaceMesh& mesh);

/// A surface that bounds a volume: watertight, manifold, outward, free of self-intersections. A
/// clean one is returned as it is; otherwise the safest repair that works (weld, drop degenerate
/// and double faces, orient, stitch, fill small holes, unite touching components), else an alpha
/// wrap. Open sheets are thickened when `file.thickness` is given.
/// @throws InputError  neither; says what the surface is and what would help
SurfaceMesh repair(const SurfaceMesh& mesh, const MeshFile& file, Diagnosis& diagnosis,
                   RepairReport& report);

}  // namespace carillon::solvers::mesh::repair
