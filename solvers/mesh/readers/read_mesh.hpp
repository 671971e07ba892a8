#pragma once

#include <string>
#include <vector>

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

/// Ending of a file name in small letters, e.g. ".obj"; decides which reader is used.
std::string mesh_extension(const std::string& path);

/// Who reads a mesh file, by its ending.
enum class FileKind {
  surface,     ///< read_surface()
  tetrahedra,  ///< read_msh()
  scene,       ///< imported::import_file(), in the mesher's process: nodes with names
  cad          ///< likewise: solids
};
/// @throws InputError  no kind that is read; says how to convert those that are known
FileKind kind_of(const std::string& path);

/// Whether it has nodes (or solids) with names, of which each can be an object.
bool has_nodes(const std::string& path);

/// Whether an MSH file is of a version that only Gmsh itself reads: 1, or 4.0 in binary.
/// @throws FileError  cannot be read
bool is_old_msh(const std::string& path);

/// The files that hold a mesh: its own, and what a glTF file has beside it. In the order in which
/// they are named; those that are not there are left out.
/// @param pictures  those of textures too
/// @throws FileError  cannot be read
std::vector<std::string> files_of(const std::string& path, bool pictures);

/// Whether a body comes as tetrahedra, which cannot be made smaller, and not as a surface.
bool gives_tetrahedra(const MeshFile& file);

/// Factor from file units to metres: `length` / longest side when given, else `unit`.
/// @param own_unit  what the file says its unit is [m]; counts where `unit` is 0
/// @throws InputError  the body is outside 1 mm to 10 m and any_size is off; suggests the unit
double scale_to_metres(const Box& box, const MeshFile& file, double own_unit = 1);

}  // namespace carillon::solvers::mesh::readers
