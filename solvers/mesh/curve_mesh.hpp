#pragma once

#include <cstdint>
#include <functional>
#include <numbers>
#include <optional>

#include "solvers/mesh/tet_mesh.hpp"

namespace carillon::solvers::mesh {

/// The true surface of a body: what curved boundary nodes are moved to.
struct SurfaceProjection {
  /// Point nearest to one near it. `normal` is the outward direction of the straight boundary
  /// there: the answer lies on a side of the body that looks the same way, so a node of a thin wall
  /// stays on its own side.
  std::function<Vec3(const Vec3& point, const Vec3& normal)> to_surface;
  /// Point nearest to one between two vertices on the sharp line that leads from one to the other;
  /// none where no line does. Empty: the surface has no lines.
  std::function<std::optional<Vec3>(const Vec3& from, const Vec3& to, const Vec3& between)> to_line;
  /// Edges between faces that meet at more follow their line [rad].
  double line_angle = 40 * std::numbers::pi / 180;
};

/// The same tetrahedra, whose nodes are all used, with nodes of an order; nodes of boundary edges
/// and faces are moved to `truth` (none: straight, and no finer_nodes), and those inside follow.
/// Edges between faces that meet at more than truth.line_angle follow the line that they are part
/// of. A node that would move by more than 0.3 of its edge is left on the chord. An element whose
/// Jacobian would turn negative is straightened and counted.
///
/// finer_nodes start from the curved elements of the order and are moved on to the surface again.
/// An element that was straightened and is sound at the next order is curved there: the difference
/// is an error that the mesh has. One that the next order would fold stays as it is, and finer_gaps
/// tells what it lacks.
TetMesh curve_mesh(const TetMesh& linear, int order, const SurfaceProjection& truth,
                   std::int64_t& straightened);

}  // namespace carillon::solvers::mesh
