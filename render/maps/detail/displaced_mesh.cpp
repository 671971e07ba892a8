#include "render/maps/detail/displaced_mesh.hpp"

#include <fmt/format.h>

#include <limits>

#include "core/error.hpp"

namespace carillon::render::maps {

solvers::mesh::SurfaceMesh displaced_mesh(const TexturedFace& face, int columns, int rows) {
  if (columns < 1 || rows < 1 ||
      (columns + std::int64_t{1}) * (rows + std::int64_t{1}) >
          std::numeric_limits<std::int32_t>::max()) {
    throw core::InputError(fmt::format("a face as {} x {} rectangles", columns, rows),
                           "at least 1 x 1, and no more than 2^31 vertices");
  }
  if (!(face.size.array() > 0).all() || !face.size.allFinite()) {
    throw core::InputError(
        fmt::format("a textured face of {} m x {} m has no extent", face.size.x(), face.size.y()));
  }
  if (face.map == nullptr) throw core::InputError("displaced mesh: the face has no map");
  const SurfaceMap relief = integrated_relief(*face.map);
  solvers::mesh::SurfaceMesh mesh;
  const Eigen::Vector2d step(face.size.x() / columns, face.size.y() / rows);
  const Vec3 normal = face.normal();
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      const Eigen::Vector2d uv(i * step.x(), j * step.y());
      mesh.vertices.push_back(face.origin + uv.x() * face.u + uv.y() * face.v +
                              height_at(relief, uv) * normal);
    }
  }
  const std::int32_t across = columns + 1;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const std::int32_t corner = j * across + i;
      mesh.triangles.push_back({corner, corner + 1, corner + across + 1});
      mesh.triangles.push_back({corner, corner + across + 1, corner + across});
    }
  }
  return mesh;
}

}  // namespace carillon::render::maps
