#pragma once

#include <cstddef>
#include <vector>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::solvers::mesh {

struct SpreadPoint {
  Vec3 at;
  std::size_t triangle;  ///< that it lies on
};

/// About `count` points spread evenly over a surface's area: a sequence of low discrepancy (Roberts
/// 2018, "R2"), in each triangle as many as its area asks.
std::vector<SpreadPoint> spread_points(const SurfaceMesh& surface, std::size_t count);

}  // namespace carillon::solvers::mesh
