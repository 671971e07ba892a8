#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/vectors.hpp"

namespace carillon::solvers::mesh {

using Triangle = std::array<std::int32_t, 3>;

/// Triangles that bound a body, counter-clockwise seen from outside. Metres once a unit is known.
struct SurfaceMesh {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
};

/// Volume enclosed [m^3]; negative when the faces look inward, meaningless when open.
double signed_volume(const SurfaceMesh& mesh);
/// Total area [m^2].
double area(const SurfaceMesh& mesh);

/// Axis-aligned box; extent() are its three side lengths.
struct Box {
  Vec3 low = Vec3::Constant(0);
  Vec3 high = Vec3::Constant(0);
  Vec3 extent() const { return high - low; }
  double longest_side() const { return extent().maxCoeff(); }
};
Box bounding_box(const std::vector<Vec3>& points);

/// Component of every triangle, numbered from 0 in the order of first triangles; triangles belong
/// together when they share an edge.
std::vector<std::int32_t> edge_components(const std::vector<Triangle>& triangles);

}  // namespace carillon::solvers::mesh
