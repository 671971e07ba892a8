#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::solvers::mesh::tetrahedra {

/// Triangles of a surface in a tree that answers where is nearest and what lies ahead (CGAL).
/// Degenerate triangles are left out.
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

  /// Distance straight in from the middle of a triangle to the side across; infinite when the
  /// surface is open there.
  double thickness_below(std::size_t triangle) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace carillon::solvers::mesh::tetrahedra
