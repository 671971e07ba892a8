#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "solvers/mesh/tet_mesh.hpp"

namespace carillon::solvers::families {

/// Triangles of a plane region whose edges may be curved: a formula gives the true point for
/// barycentric coordinates in a triangle. Formulas of neighbours agree on their common edge.
struct PlanarGrid {
  std::int32_t vertices = 0;
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::function<Vec2(std::size_t triangle, const Eigen::Vector3d& barycentric)> point;
};

/// Body swept from a plane grid: t in [0, 1] runs through `layers` layers of prisms, each cut
/// into three tetrahedra so that neighbours fit (Dompierre et al. 1999: every quadrilateral is cut
/// from its smallest vertex). Nodes of every order, finer_nodes too, are values of `map`, so those
/// of the boundary lie on the true surface.
/// @param map     (plane point, t) -> position [m]; either orientation
/// @param closed  t = 1 is t = 0 again, of a sweep all around; three layers at least
mesh::TetMesh extrude(const PlanarGrid& grid, int layers, int order,
                      const std::function<Vec3(const Vec2&, double)>& map, bool closed = false);

/// nx x ny rectangles over [0, 1]^2, each cut in two along the same diagonal. `periodic` joins the
/// side x = 1 to the side x = 0 (points keep their own x, so an angle may run through).
PlanarGrid rectangle_grid(int nx, int ny, bool periodic);

/// A disc about the origin without a pole: a square of cells in the middle, rings around it.
struct DiscGrid {
  int around = 16;              ///< cells around, a multiple of 4; the square has around/4 a side
  double core = 0.5;            ///< radius of the square's corners
  int transition = 1;           ///< rings between the square and the first circle
  std::vector<double> circles;  ///< radii that cell edges follow, ascending, all above core

  std::int64_t cells() const;
};
PlanarGrid disc_grid(const DiscGrid& disc);

/// A flat disc of cells of about one size; its only circles are those out to its radius.
/// @param around  cells around, a multiple of 4
DiscGrid flat_disc(int around, double radius, double cell);

}  // namespace carillon::solvers::families
