#pragma once

#include <memory>
#include <optional>

#include "solvers/mesh/curve_mesh.hpp"
#include "solvers/mesh/tetrahedra/surface_search.hpp"

namespace carillon::solvers::mesh::tetrahedra {

/// Edges between faces that meet at more than this are features [degrees].
constexpr double feature_angle_deg = 40;

/// The feature lines of a surface in a tree that answers where is nearest (CGAL).
class FeatureLines {
 public:
  explicit FeatureLines(const SurfaceMesh& surface);
  ~FeatureLines();

  /// Point nearest to one between two points of the lines; none where either is on no line or the
  /// line found leads another way.
  std::optional<Vec3> nearest(const Vec3& from, const Vec3& to, const Vec3& between) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// What curved nodes are moved to, while both live.
SurfaceProjection projection_on(const SurfaceSearch& surface, const FeatureLines& lines);

}  // namespace carillon::solvers::mesh::tetrahedra
