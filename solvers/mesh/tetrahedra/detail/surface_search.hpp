#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "solvers/mesh/curve_mesh.hpp"
#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::solvers::mesh::tetrahedra {

/// Edges between faces that meet at more than this are features [degrees].
constexpr double feature_angle_deg = 40;

/// Triangles of a surface, and the feature lines between them, in trees that answer where is
/// nearest and what lies ahead (CGAL). Degenerate triangles are left out.
class SurfaceSearch {
 public:
  explicit SurfaceSearch(const SurfaceMesh& surface);
  ~SurfaceSearch();
  SurfaceSearch(SurfaceSearch&&) noexcept;

  struct Hit {
    Vec3 point;
    std::size_t triangle;  ///< index into the surface's triangles
  };
  Hit nearest(const Vec3& point) const;

  /// Nearest point of the surface whose side looks along `normal`: the nearest point of all when
  /// it does, else the nearest on the line through `point`; none when that line meets none.
  std::optional<Hit> nearest_on_side(const Vec3& point, const Vec3& normal) const;

  /// Point of the feature lines nearest to one between two points of them; none where either is on
  /// no line or the line found leads another way.
  std::optional<Vec3> nearest_on_line(const Vec3& from, const Vec3& to, const Vec3& between) const;

  /// Both as what curved nodes are moved to; while this object lives.
  SurfaceProjection projection() const;

  /// Distance straight in from the middle of a triangle to the side across; infinite when the
  /// surface is open there.
  double thickness_below(std::size_t triangle) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace carillon::solvers::mesh::tetrahedra
