#pragma once

#include <string>

#include "solvers/mesh/readers/file_kind.hpp"
#include "solvers/mesh/shape_source.hpp"

namespace carillon::solvers::mesh::readers {

/// Triangles of an OBJ, OFF, PLY or STL file (polygons are cut into triangles), as they stand in
/// the file: no welding except for STL, whose format has no shared vertices. Vertices that no face
/// uses are left out. Text may be UTF-8 or, with its byte order mark, UTF-16.
/// @throws InputError  malformed; names file and line (or byte), and what was expected; or a file
/// of
///                     another kind
/// @throws FileError   cannot be read
SurfaceMesh read_surface(const std::string& path);

/// Tetrahedra of a Gmsh MSH file, versions 2 to 2.2, 4.0 (text) and 4.1, ASCII or binary, order 1
/// to 4; physical groups become regions.
/// @throws InputError  malformed, an element folded or without volume, or elements that meet but do
///                     not share whole faces (a hanging node)
/// @throws FileError   cannot be read
TetMesh read_msh(const std::string& path);

/// Whether a body comes as tetrahedra, which cannot be made smaller, and not as a surface.
bool gives_tetrahedra(const MeshFile& file);

/// Factor from file units to metres: `length` / longest side when given, else `unit`.
/// @param own_unit  what the file says its unit is [m]; counts where `unit` is 0
/// @throws InputError  the body is outside 1 mm to 10 m and any_size is off; suggests the unit
double scale_to_metres(const Box& box, const MeshFile& file, double own_unit = 1);

}  // namespace carillon::solvers::mesh::readers
