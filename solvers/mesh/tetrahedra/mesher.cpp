#include "solvers/mesh/tetrahedra/mesher.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "core/error.hpp"
#include "solvers/mesh/keep_volume.hpp"
#include "solvers/mesh/sizing.hpp"
#include "solvers/mesh/tetrahedra/delaunay.hpp"
#include "solvers/mesh/tetrahedra/detail/feature_lines.hpp"
#include "solvers/mesh/tetrahedra/detail/remesh.hpp"
#include "solvers/mesh/tetrahedra/detail/size_field.hpp"
#include "solvers/mesh/tetrahedra/detail/surface_fit.hpp"

namespace carillon::solvers::mesh::tetrahedra {
namespace {

/// A relaxation under which bending limits nothing.
constexpr double no_limit = std::numeric_limits<double>::infinity();

/// How a surface is to be remeshed.
struct RemeshPlan {
  double coarsest = 0;  ///< [m]
  double relax = 1;     ///< by how much less than measured the surface is taken to bend
};

/// Tetrahedra behind a surface remeshed by a plan.
double expected_count(const SurfaceMesh& surface, const SizeField& field, const RemeshPlan& plan) {
  const auto sizes = vertex_sizes(surface, field, plan.coarsest, plan.relax);
  double triangles = 0;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    double mean = 0;
    for (std::int32_t v : surface.triangles[t]) mean += sizes[static_cast<std::size_t>(v)] / 3;
    // Edges end a tenth below the size on average.
    triangles += field.area[t] / (0.433 * 0.8 * mean * mean);
  }
  return 1.6 * triangles + 5 * field.volume / std::pow(plan.coarsest, 3);
}

RemeshPlan make_plan(const SizeField& field, const SurfaceMesh& surface,
                     const MeshOptions& options) {
  RemeshPlan plan;
  const double longest = bounding_box(surface.vertices).longest_side();
  const double wall = field.wall();
  const auto count = [&](double edge) {
    return static_cast<std::int64_t>(std::min(1e15, field.tetrahedra(edge, no_limit)));
  };
  MeshOptions edges = options;
  edges.element_size *= 1.06;  // remeshing leaves edges up to 4/3 of its target
  // A shape read from a file has more detail than a generated one: high orders may not save as
  // much on the size, and some elements go across every body.
  edges.order = std::min(options.order, 2);
  plan.coarsest = cell_size(edges, wall, longest, count);
  if (options.element_size <= 0)
    plan.coarsest = std::min((options.order > 2 ? 1.35 : 1.0) * plan.coarsest, longest / 8);

  // A surface full of detail, or noisy, is followed less closely before it takes far more elements
  // than a plain one would.
  const double plain = field.tetrahedra(plan.coarsest, no_limit);
  const double maximum =
      std::min(0.8 * static_cast<double>(options.max_elements), 1.5 * plain + 1500);
  constexpr double max_relaxed = 100;
  while (plan.relax < max_relaxed && expected_count(surface, field, plan) > maximum)
    plan.relax *= 1.25;
  return plan;
}

/// One surface remeshed and filled.
/// @throws SolverError  the remeshed surface crosses itself or lost volume, or Gmsh's reason
TetMesh fill_remeshed(const SurfaceMesh& surface, const RemeshPlan& plan, const SizeField& field,
                      const SurfaceSearch& search) {
  const auto remeshed = remesh_apart(surface, field, plan.coarsest, plan.relax, search);
  if (!remeshed || remeshed->triangles.empty())
    throw core::SolverError(
        fmt::format("remeshed to edges of {:.3g} m the surface crosses itself", plan.coarsest));
  // Remeshing must not lose a piece or close a hole in a handle.
  const double volume = signed_volume(*remeshed);
  if (std::abs(volume - field.volume) > 0.05 * field.volume)
    throw core::SolverError(
        fmt::format("remeshed to edges of {:.3g} m the surface encloses {:.3g} of its volume",
                    plan.coarsest, volume / field.volume));
  return fill_with_tetrahedra(*remeshed);
}

/// Elements of the wanted order on the surface, with its volume.
/// @throws SolverError  they do not keep it
MeshResult fit_to_surface(const TetMesh& linear, const SurfaceMesh& surface,
                          const SurfaceSearch& search, const FeatureLines& lines, int order) {
  constexpr double max_volume_error = 1e-4;
  const SurfaceProjection truth = projection_on(search, lines);
  std::int64_t straightened = 0;
  MeshResult result;
  result.mesh = curve_mesh(linear, order, truth, straightened);
  const double added = keep_volume(result.mesh, signed_volume(surface), truth);
  result.quality = measure_quality(result.mesh);
  result.quality.volume_added = added;
  result.quality.straightened = straightened;
  measure_fit(result.mesh, surface, search, result.quality);
  if (!(std::abs(result.quality.volume_error) <= max_volume_error))
    throw core::SolverError(fmt::format("the elements have {:.5f} of the surface's volume",
                                        1 + result.quality.volume_error));
  return result;
}

/// Elements with angles that small are mended where their surface has none.
constexpr double small_angle_deg = 3;

/// What a try is worth: the surface kept, no slivers, small distance.
bool is_better(const MeshQuality& one, const MeshQuality& other, double longest, double wall) {
  const auto rank = [longest, wall](const MeshQuality& quality) {
    return std::tuple(follows_surface(quality, longest, wall),
                      std::min(quality.min_dihedral_deg, small_angle_deg), -quality.hausdorff);
  };
  return rank(one) > rank(other);
}

void check_bound(const TetMesh& mesh, double edge, const MeshOptions& options) {
  const auto count = static_cast<std::int64_t>(mesh.element_count());
  if (count <= options.max_elements) return;
  const double excess = static_cast<double>(count) / static_cast<double>(options.max_elements);
  fail_element_bound(count, options, 1.3 * edge * std::cbrt(excess * excess));
}

}  // namespace

MeshResult tetrahedralise(const SurfaceMesh& surface, const MeshOptions& options) {
  const SurfaceSearch search(surface);
  const FeatureLines lines(surface);
  const SizeField field = measure_sizes(surface, search);
  if (!(field.volume > 0))
    throw core::InputError("the surface encloses no volume",
                           "a clean closed surface that looks outward is needed");
  const double longest = bounding_box(surface.vertices).longest_side();
  const double wall = field.wall();
  RemeshPlan plan = make_plan(field, surface, options);

  // Chords of a thin wall's two sides may cross, and limbs be cut off; smaller triangles keep them
  // apart and follow them. The last resort is the surface as it came.
  constexpr int tries = 4;
  const bool sharp = field.sharpest_edge < small_angle_deg * std::numbers::pi / 180;
  int tries_with_slivers = 0;
  std::string reason;
  std::optional<MeshResult> best;
  for (int attempt = 0; attempt < tries; ++attempt) {
    if (field.tetrahedra(plan.coarsest, no_limit) > static_cast<double>(options.max_elements))
      break;
    try {
      const TetMesh linear = fill_remeshed(surface, plan, field, search);
      check_bound(linear, plan.coarsest, options);
      MeshResult made = fit_to_surface(linear, surface, search, lines, options.order);
      const bool near = follows_surface(made.quality, longest, wall);
      const bool slivers = !sharp && made.quality.min_dihedral_deg < small_angle_deg;
      if (!best || is_better(made.quality, best->quality, longest, wall)) best = std::move(made);
      // Chords that nearly cross leave flat elements, which smaller ones mend at once or never.
      if (near && (!slivers || ++tries_with_slivers == 2)) break;
    } catch (const core::LimitError&) {
      if (best) break;
      throw;
    } catch (const core::SolverError& error) {
      if (tries_with_slivers > 0) break;
      if (reason.empty()) reason = error.message();
    }
    plan.coarsest *= 0.7;
    plan.relax = std::max(1.0, 0.6 * plan.relax);
  }
  if (best) return std::move(*best);
  // Its triangles alone may be too many.
  if (1.2 * static_cast<double>(surface.triangles.size()) >
      static_cast<double>(options.max_elements))
    throw core::LimitError(
        fmt::format("{}, and filling its {} triangles as they are takes more than {} elements",
                    reason, surface.triangles.size(), options.max_elements),
        "raise max_elements, or give another element_size");
  try {
    const TetMesh linear = fill_with_tetrahedra(surface);
    if (static_cast<std::int64_t>(linear.element_count()) > options.max_elements)
      throw core::LimitError(fmt::format("{}; as it is the surface takes {} elements and "
                                         "max_elements is {}",
                                         reason, linear.element_count(), options.max_elements),
                             "raise max_elements, or give another element_size");
    return fit_to_surface(linear, surface, search, lines, options.order);
  } catch (const core::LimitError&) {
    throw;
  } catch (const core::SolverError& error) {
    throw core::SolverError(fmt::format("{}; as it is: {}", reason, error.message()),
                            "another element_size may help");
  }
}

}  // namespace carillon::solvers::mesh::tetrahedra
