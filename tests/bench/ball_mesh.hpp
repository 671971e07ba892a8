#pragma once

#include <cmath>
#include <numbers>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::bench {

/// A ball about the origin, in `rings` rings from pole to pole.
inline solvers::mesh::SurfaceMesh ball(double radius, int rings) {
  solvers::mesh::SurfaceMesh mesh;
  const int around = 2 * rings;
  const double step = std::numbers::pi / rings;
  for (int i = 0; i <= rings; ++i) {
    for (int j = 0; j < around; ++j) {
      const bool pole = i % rings == 0;
      const double out = pole ? 0 : std::sin(i * step), turn = pole ? 0 : j * step;
      mesh.vertices.push_back(radius *
                              Vec3(out * std::cos(turn), out * std::sin(turn), std::cos(i * step)));
    }
  }
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < around; ++j) {
      const int a = i * around + j, b = i * around + (j + 1) % around;
      if (i > 0) mesh.triangles.push_back({a, a + around, b});
      if (i + 1 < rings) mesh.triangles.push_back({b, a + around, b + around});
    }
  }
  return mesh;
}

}  // namespace carillon::bench
