#include <algorithm>

#include "core/error.hpp"
#include "solvers/families/cone.hpp"
#include "solvers/families/family.hpp"
#include "solvers/families/polygon_meridian.hpp"
#include "solvers/families/revolve.hpp"
#include "solvers/mesh/sizing.hpp"
#include "solvers/mesh/tetrahedra/delaunay.hpp"

namespace carillon::solvers::families {

mesh::MeshResult mesh_turned(const mesh::GeneratedShape& shape, const mesh::MeshOptions& options) {
  check_parameters(shape);
  const ProfilePolygon profile = checked_profile(shape.profile, "turned");
  const double volume = turned_volume(profile), area = turned_area(profile);
  double size = 0;
  for (const auto& p : profile)
    size = std::max({size, 2 * p[0], std::abs(p[1] - profile.front()[1])});
  // Gmsh fills a wall with three tetrahedra to a pair of triangles, and a solid with regular ones.
  const auto count = [&](double cell) {
    // Counting by making the surface would not end for cells far below its size.
    const double by_size = 3.5 * area / (cell * cell) + 8.5 * volume / (cell * cell * cell);
    if (by_size > 4e6) return static_cast<std::int64_t>(std::min(by_size, 1e15));
    return static_cast<std::int64_t>(
        1.5 * static_cast<double>(revolve(profile, cell).triangles.size()) +
        8.5 * volume / (cell * cell * cell));
  };
  double cell = mesh::cell_size(options, 2 * volume / area, size, count);
  // A wall too thin for the chords of its two sides shows as a surface that cannot be filled, or as
  // elements that fold where they bend, and are left straight.
  constexpr int tries = 4;
  constexpr std::int64_t few = 50;
  for (int attempt = 1;; ++attempt, cell *= 0.7) {
    if (count(cell) > options.max_elements) mesh::fail_element_bound(count(cell), options, 0);
    try {
      const mesh::TetMesh linear = mesh::tetrahedra::fill_with_tetrahedra(revolve(profile, cell));
      std::int64_t straightened = 0;
      mesh::TetMesh mesh =
          mesh::curve_mesh(linear, options.order, project_to_turned(profile), straightened);
      const auto elements = static_cast<std::int64_t>(mesh.element_count());
      if (straightened * few <= elements || options.element_size > 0 || attempt == tries) {
        return finish(std::move(mesh), straightened);
      }
    } catch (const core::SolverError&) {
      if (attempt == tries) throw;
    }
  }
}

mesh::MeshResult mesh_cone(const mesh::GeneratedShape& shape, const mesh::MeshOptions& options) {
  return mesh_turned({"turned", {}, cone_profile(shape)}, options);
}

}  // namespace carillon::solvers::families
