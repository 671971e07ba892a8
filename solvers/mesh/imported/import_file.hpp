#pragma once

#include <string>
#include <vector>

#include "solvers/mesh/imported/paint.hpp"
#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::solvers::mesh::imported {

/// A node of a scene, a solid of a CAD file: what of the file is a body of its own.
struct ImportedNode {
  std::string name;     ///< unique in the file
  SurfaceMesh surface;  ///< transforms applied, z up; coordinates in the file's unit
  Paint paint;          ///< of its triangles; empty unless it was asked for
};

struct ImportedFile {
  double unit = 1;  ///< that the file says its coordinates are in, or that its format has [m]
  std::vector<ImportedNode> nodes;
};

/// Surfaces of a scene (glTF, GLB, DAE, FBX, 3MF, X3D: Assimp) or of a CAD file (STEP, IGES, BREP:
/// Gmsh with Open CASCADE, faces triangulated after their curvature, 40 edges to a full turn and
/// none longer than a tenth of the body).
///
/// Transforms of the nodes are applied; bodies stand with z up, turned where the format says that y
/// or x is (x, y, z of glTF become x, -z, y). Lines and points are left out, skins and morph
/// targets are at rest. Corners at one place are one vertex.
/// @param paint  base colours are read too, with the pictures that they are in
/// @throws InputError  malformed, or nothing in it has faces
/// @throws FileError   cannot be read
/// @note Loads libraries that may crash on what they are given: only the mesher's process calls it.
ImportedFile import_file(const std::string& path, bool paint = false);

/// An MSH file that readers::read_msh() does not know (version 1, or 4.0 in binary) as Gmsh writes
/// it in version 4.1.
/// @throws InputError  Gmsh cannot read it
void modernise_msh(const std::string& path, const std::string& modern);

/// One node of a file, or all as one surface.
/// @param node  its name; "": all of them
/// @throws InputError  no node has that name; says which there are
SurfaceMesh node_surface(const ImportedFile& file, const std::string& path,
                         const std::string& node);
/// Its colours, likewise.
Paint node_paint(const ImportedFile& file, const std::string& node);

}  // namespace carillon::solvers::mesh::imported
