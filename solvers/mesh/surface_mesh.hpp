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

/// Angle between two vectors [rad]; at flat and at sharp angles too, where acos loses half the
/// digits.
double angle_between(const Vec3& one, const Vec3& two);

/// Solid angle of a triangle seen from the origin, positive when its normal points away (van
/// Oosterom and Strackee 1983).
double solid_angle(const Vec3& a, const Vec3& b, const Vec3& c);

/// How often a surface winds around a point, its solid angle over 4 pi: 1 inside of a closed one
/// that looks outward, 0 outside.
double winding_number(const SurfaceMesh& mesh, const Vec3& point);

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

/// The pieces of a surface, each with its own vertices, numbered as its triangles meet them;
/// `component` as edge_components() gives it.
std::vector<SurfaceMesh> split(const SurfaceMesh& mesh, const std::vector<std::int32_t>& component);

}  // namespace carillon::solvers::mesh
