#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "solvers/mesh/tet_mesh.hpp"

namespace carillon::solvers::mesh {

/// A plane normal to an axis.
struct MirrorPlane {
  int axis = 0;         ///< 0 to 2: x, y, z
  double position = 0;  ///< [m]
  bool operator==(const MirrorPlane&) const = default;
};

/// The image of a point.
Vec3 reflect(const Vec3& point, const MirrorPlane& plane);

/// What lies above every mirror plane of a body, and how the body comes from it.
struct MirroredPart {
  TetMesh mesh;  ///< its faces are those of the body; those that lie in a plane are left out
  std::vector<MirrorPlane> planes;     ///< by ascending axis
  Box box;                             ///< of the whole body [m]
  std::vector<std::int32_t> elements;  ///< the body's element of each of the part's
  /// Of each of the body's nodes: the part's node that it is an image of, and the planes that it
  /// lies below, bit k for planes[k].
  std::vector<std::int32_t> nodes;
  std::vector<std::uint8_t> images;

  std::size_t image_count() const { return std::size_t{1} << planes.size(); }
};

/// The smallest part of a mesh beside its planes of symmetry. A plane counts where it is normal to
/// an axis, halves the bounding box and maps every element onto one of the same region, node by
/// node and with the nodes of the next order (finer_nodes), to 1e-9 of the longest side. Nodes of
/// the part that lie in a plane to that accuracy are moved into it.
/// @param planes_wanted  of the axes, which to look for
/// @return nothing where there is no such plane
std::optional<MirroredPart> mirrored_part(const TetMesh& mesh, std::span<const int> planes_wanted);

/// A mesh and its images in planes that it touches from above, one body; by the planes' order, each
/// joined to the images of those before. Nodes within 1e-9 of the longest side of a plane are
/// shared. Faces are the body's.
TetMesh unfold(const TetMesh& part, std::span<const MirrorPlane> planes);

/// A mesh of a body that is symmetric in the planes that halve its bounding box, with elements that
/// are, too: what lies above every such plane that cuts no element, and its images.
TetMesh symmetrised(const TetMesh& mesh);

}  // namespace carillon::solvers::mesh
