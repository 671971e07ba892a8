#pragma once

#include <string>
#include <vector>

namespace carillon::solvers::mesh::readers {

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

/// A name as glTF files have it, without its percent-encoding (RFC 3986): "a%20b.bin" is "a b.bin".
std::string decoded_uri(const std::string& uri);

}  // namespace carillon::solvers::mesh::readers
