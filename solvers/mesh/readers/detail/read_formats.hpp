#pragma once

#include <string>
#include <string_view>

#include "solvers/mesh/readers/detail/polygon_mesh.hpp"

namespace carillon::solvers::mesh::readers {

/// One reader for each format: the file's bytes in, polygons out. `path` is for messages only.
/// No reader reserves memory for more than the bytes at hand can describe.
/// @throws InputError  malformed; names file and line (or byte) and what was expected
PolygonMesh read_obj(const std::string& path, std::string_view bytes);
PolygonMesh read_off(const std::string& path, std::string_view bytes);
PolygonMesh read_ply(const std::string& path, std::string_view bytes);
/// Each corner has a vertex of its own: the format has none shared.
PolygonMesh read_stl(const std::string& path, std::string_view bytes);

}  // namespace carillon::solvers::mesh::readers
