#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "solvers/mesh/shape_source.hpp"

namespace carillon::solvers::mesher {

/// The triangles of a file, in metres.
struct FileSurface {
  mesh::SurfaceMesh surface;
  std::vector<std::string> joined;  ///< names of its nodes, where several are one surface here
};

/// Of any kind of file but one of tetrahedra.
/// @throws InputError, FileError  as readers::read_surface(), imported::import_file() and
///         readers::scale_to_metres() do
FileSurface scaled_surface(const mesh::MeshFile& file);

/// Tetrahedra of an MSH file of any version, in metres.
/// @throws InputError, FileError  as readers::read_msh() and readers::scale_to_metres() do
mesh::TetMesh scaled_tetrahedra(const mesh::MeshFile& file);

/// Corners of the boundary faces as a surface of its own.
mesh::SurfaceMesh boundary_surface(const mesh::TetMesh& mesh);

/// What each file holds, as mesher::file_contents_from_json() reads it; of one that cannot be read
/// its "error".
nlohmann::json describe_files(const std::vector<std::string>& paths);

/// Colours of the file's base colour at points of the body [m], each red, green, blue, linear, 0 to
/// 1; empty where the file has none that show.
std::vector<Vec3> colours_of(const mesh::MeshFile& file, std::span<const Vec3> points);

}  // namespace carillon::solvers::mesher
