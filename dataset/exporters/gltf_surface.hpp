#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "solvers/modes/modes.hpp"

namespace carillon::dataset::exporters {

/// Three values for each vertex, as they lie in a file.
using GltfVectors = std::vector<std::array<float, 3>>;

/// From our axes, z up, to glTF's, y up: (x, y, z) becomes (x, z, -y), a quarter turn about x.
std::array<float, 3> to_gltf_axes(const Vec3& vector);

/// A surface in triangles with a normal at each vertex, split where it has an edge; in glTF's axes.
struct GltfSurface {
  solvers::mesh::SurfaceMesh mesh;   ///< as it came, in our axes
  std::vector<std::uint32_t> nodes;  ///< node of the surface at each vertex
  GltfVectors positions;             ///< [m]
  GltfVectors normals;               ///< unit length
  /// Triangles of each region, three vertices each; those without a face are empty.
  std::vector<std::vector<std::uint32_t>> regions;
  std::vector<std::uint32_t> corners;  ///< vertex at each corner of `mesh`
  std::vector<std::uint32_t> smooth;   ///< number of its normal
};

/// @param face_regions  region of each face of the surface; empty: all are of the first
/// @param regions       how many there are
GltfSurface gltf_surface(const solvers::modes::ModeSurface& surface,
                         std::span<const std::int32_t> face_regions, std::size_t regions);

/// A shape as a morph target: what a weight of 1 adds to the surface.
struct GltfTarget {
  GltfVectors positions;  ///< [m]
  /// Half the difference of the normals at weights of 1 and -1: what they change by is odd for
  /// small swings.
  GltfVectors normals;
};

/// @param displacements  3 values for each node of the surface, in our axes [m]
GltfTarget gltf_target(const GltfSurface& surface, const Eigen::VectorXd& displacements);

}  // namespace carillon::dataset::exporters
