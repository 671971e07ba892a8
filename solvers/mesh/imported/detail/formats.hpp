#pragma once

#include "solvers/mesh/imported/import_file.hpp"

namespace carillon::solvers::mesh::imported {

/// Which way is up in the coordinates that a library hands out.
enum class Up { x, y, z };

/// By Assimp. @throws InputError  it cannot read the file
ImportedFile read_scene(const std::string& path, bool paint);

/// By Gmsh, with Open CASCADE. @throws InputError  it cannot read the file, or cannot mesh it
ImportedFile read_cad(const std::string& path);

/// The unit that a DAE, X3D or 3MF file says it is in, or else its format's [m].
/// @throws InputError  no such file in it, or XML that cannot be read
double unit_in_xml(const std::string& path, const std::string& extension);

}  // namespace carillon::solvers::mesh::imported
