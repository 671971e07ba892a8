#pragma once

#include <array>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::render {

/// Whether a triangle and an axis-aligned box share a point, both closed: separating axes over the
/// box's three faces, the triangle's plane and the nine products of their edges (Akenine-Moller
/// 2001). Exact up to rounding; a contact counts when it is within `tolerance` of the box.
bool triangle_meets_box(const std::array<Vec3, 3>& triangle, const Vec3& centre,
                        const Vec3& half_extent, double tolerance);

}  // namespace carillon::render
