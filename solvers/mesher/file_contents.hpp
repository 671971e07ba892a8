#pragma once

#include <string>
#include <vector>

#include "solvers/mesh/shape_signature.hpp"
#include "solvers/mesh/shape_source.hpp"
#include "solvers/mesher/mesh_child.hpp"

namespace carillon::solvers::mesher {

/// A surface in a mesh file, in the file's unit of length.
struct SurfaceContents {
  std::string name;  ///< of its node; "" for a file as a whole
  mesh::ShapeSignature signature;
  mesh::Box bounds;
  double area = 0, volume = 0;
  std::int64_t triangles = 0;
};

/// What is in a mesh file.
struct FileContents {
  std::string error;                   ///< why it cannot be read; "" where it can
  double unit = 1;                     ///< that it says its coordinates are in [m]
  SurfaceContents whole;               ///< all of it as one surface
  std::vector<SurfaceContents> nodes;  ///< of a file that has them: each, also where it is the only
};

/// Reads files in a process of the mesher's: one for all of them, but that a file which brings the
/// process down is found and has its error.
/// @return as many as paths
/// @throws StorageError  as mesh_in_child()
std::vector<FileContents> read_contents(const std::vector<std::string>& paths,
                                        const ChildLimits& limits);

/// Colours of a file's base colour (factor, picture and corners' colours) at points of the body
/// that it describes, by the nearest face: linear reflectance, red, green and blue, 0 to 1.
/// @param points  [m]
/// @return as many as points; none where the file has no colours, or its format none that are read
/// @throws as mesh_in_child()
std::vector<Vec3> colours_in_child(const mesh::MeshFile& file, const std::vector<Vec3>& points,
                                   const ChildLimits& limits);

}  // namespace carillon::solvers::mesher
