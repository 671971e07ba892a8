#pragma once

#include "render/maps/surface_map.hpp"

namespace carillon::render::maps {

/// A textured face as triangles: an open sheet (not a slab) of columns x rows rectangles, each cut
/// in two, with (columns + 1) (rows + 1) vertices on the relief, seen counter-clockwise from
/// outside. A normal map's heights are those of integrated_relief().
/// @throws InputError  fewer than one rectangle, a face without extent, or more vertices than a
///                     mesh can number
solvers::mesh::SurfaceMesh displaced_mesh(const TexturedFace& face, int columns, int rows);

}  // namespace carillon::render::maps
