#include "solvers/mesher.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/error.hpp"
#include "solvers/delaunay.hpp"
#include "solvers/families/sizing.hpp"
#include "solvers/remesh.hpp"
#include "solvers/size_field.hpp"

namespace carillon::solvers {
namespace {

/// How a surface is to be remeshed.
struct RemeshPlan {
  double coarsest = 0;  ///< [m]
  int levels = 0;       ///< halvings for the places that ask for finer triangles
  double relax = 1;     ///< angle of bending per triangle, in units of 30 degrees
};

/// Halvings below the coarsest size that a twentieth of the area asks for, two at most.
int levels_wanted(const SizeField& field, double coarsest, double relax) {
  std::vector<std::pair<double, double>> sizes;
  for (std::size_t t = 0; t < field.area.size(); ++t)
    sizes.emplace_back(field.limit(t, relax), field.area[t]);
  std::sort(sizes.begin(), sizes.end());
  double seen = 0;
  for (const auto& [size, part] : sizes) {
    seen += part;
    if (seen < 0.05 * field.total_area) continue;
    return std::clamp(static_cast<int>(std::lround(std::log2(coarsest / size))), 0, 2);
  }
  return 0;
}

RemeshPlan make_plan(const SizeField& field, const SurfaceMesh& surface,
                     const MeshOptions& options) {
  RemeshPlan plan;
  const double longest = bounding_box(surface.vertices).longest_side();
  // Without a size given, a surface full of detail is followed less closely before it takes more
  // elements than a plain one would.
  constexpr double most_relaxed = 4;
  const double enough = options.order <= 2 ? 6000 : 3000;
  if (options.element_size <= 0)
    while (plan.relax < most_relaxed && field.tetrahedra(0.2 * longest, plan.relax) > enough)
      plan.relax *= 1.25;
  MeshOptions edges = options;
  edges.element_size *= 1.06;  // remeshing leaves edges up to 4/3 of its target
  plan.coarsest = cell_size(edges, 2 * field.volume / field.total_area, longest, [&](double edge) {
    return static_cast<std::int64_t>(std::min(1e15, field.tetrahedra(edge, plan.relax)));
  });
  plan.levels = levels_wanted(field, plan.coarsest, plan.relax);
  return plan;
}

/// One surface remeshed and filled.
/// @throws SolverError  the remeshed surface crosses itself, or Gmsh's reason
TetMesh fill_remeshed(const SurfaceMesh& surface, const RemeshPlan& plan, const SizeField& field,
                      const SurfaceSearch& search) {
  const SurfaceMesh fitted = remesh(surface, plan.coarsest, plan.levels, [&](const Vec3& at) {
    return field.limit(search.nearest(at).triangle, plan.relax);
  });
  // Remeshing must not lose a piece or close a hole in a handle.
  if (fitted.triangles.empty() || intersects_itself(fitted))
    throw core::SolverError(
        fmt::format("remeshed to edges of {:.3g} m the surface crosses itself", plan.coarsest));
  const double volume = signed_volume(fitted);
  if (std::abs(volume - field.volume) > 0.05 * field.volume)
    throw core::SolverError(
        fmt::format("remeshed to edges of {:.3g} m the surface encloses {:.3g} of its volume",
                    plan.coarsest, volume / field.volume));
  return fill_with_tetrahedra(fitted);
}

void check_bound(const TetMesh& mesh, const RemeshPlan& plan, const MeshOptions& options) {
  const auto count = static_cast<std::int64_t>(mesh.element_count());
  if (count <= options.max_elements) return;
  const double excess = static_cast<double>(count) / static_cast<double>(options.max_elements);
  fail_element_bound(count, options, 1.5 * plan.coarsest * std::sqrt(excess));
}

}  // namespace

TetMesh tetrahedralise(const SurfaceMesh& surface, const MeshOptions& options) {
  const SurfaceSearch search(surface);
  const SizeField field = measure_sizes(surface, search);
  if (!(field.volume > 0))
    throw core::InputError("the surface encloses no volume",
                           "a clean closed surface that looks outward is needed");
  RemeshPlan plan = make_plan(field, surface, options);

  // Chords of a thin wall's two sides may cross; smaller triangles keep them apart. The last
  // resort is the surface as it came.
  constexpr int tries = 3;
  std::string first_reason;
  for (int attempt = 0; attempt < tries; ++attempt) {
    if (field.tetrahedra(plan.coarsest, plan.relax) > 2 * static_cast<double>(options.max_elements))
      break;
    try {
      TetMesh mesh = fill_remeshed(surface, plan, field, search);
      check_bound(mesh, plan, options);
      return mesh;
    } catch (const core::SolverError& error) {
      if (!error.hint().empty()) throw;  // the bound on elements, which smaller ones only exceed
      if (first_reason.empty()) first_reason = error.message();
    }
    plan.coarsest *= 0.6;
    plan.relax = std::max(1.0, 0.6 * plan.relax);
    plan.levels = levels_wanted(field, plan.coarsest, plan.relax);
  }
  try {
    TetMesh mesh = fill_with_tetrahedra(surface);
    check_bound(mesh, plan, options);
    return mesh;
  } catch (const core::SolverError& error) {
    if (!error.hint().empty()) throw;
    throw core::SolverError(
        fmt::format("{}; unchanged it fails too: {}", first_reason, error.message()));
  }
}

}  // namespace carillon::solvers
