#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::solvers::mesh::readers {

/// What an MSH file holds of volumes, before nodes are renumbered.
struct MshFile {
  std::vector<Vec3> nodes;
  std::map<std::int64_t, std::string> volume_names;  ///< physical volume -> name
  int order = 0;                                     ///< of all tetrahedra; 0: there are none
  std::vector<std::int32_t> tetrahedra;              ///< indices into nodes, Gmsh's node order
  std::vector<std::int64_t> groups;                  ///< physical volume of each; 0: none
  std::int64_t other_elements = 0;                   ///< points, lines, triangles ...
};

/// Parses Gmsh's MSH format 2.x and 4.1, ASCII and binary, either byte order (Gmsh reference
/// manual, chapter "File formats").
/// @throws InputError  malformed; volume elements other than tetrahedra, tetrahedra of several
///                     orders or of one above 4; other versions
MshFile parse_msh(const std::string& path, std::string_view bytes);

}  // namespace carillon::solvers::mesh::readers
