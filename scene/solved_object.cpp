#include "scene/solved_object.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "mpi/comm.hpp"
#include "scene/pitch.hpp"
#include "scene/strikes.hpp"
#include "scene/turned_sets.hpp"
#include "solvers/eigen/cached_modes.hpp"
#include "solvers/eigen/extract.hpp"
#include "solvers/families/families.hpp"
#include "solvers/mesh/mesh_warnings.hpp"

namespace carillon::scene {

using core::InputError;

solvers::modes::Band read_band(core::ConfigNode& modes, const solvers::modes::Band& otherwise) {
  using core::Dimension;
  solvers::modes::Band band;
  band.min_frequency =
      modes.not_negative("min_frequency", Dimension::frequency, otherwise.min_frequency);
  band.max_frequency =
      modes.quantity("max_frequency", Dimension::frequency, otherwise.max_frequency);
  if (!(band.max_frequency > band.min_frequency)) {
    modes.fail("max_frequency", "must be above min_frequency");
  }
  band.max_modes = static_cast<int>(modes.integer("max_modes", 1, 100000, otherwise.max_modes));
  return band;
}

std::vector<synth::material::Material> listed(const RegionMaterials& materials) {
  std::vector<synth::material::Material> list;
  for (const auto& [region, material] : materials) list.push_back(material);
  return list;
}

std::vector<synth::material::Material> assign_materials(const RegionMaterials& materials,
                                                        const std::vector<std::string>& regions) {
  if (const auto all = materials.find(""); all != materials.end()) {
    return std::vector<synth::material::Material>(regions.size(), all->second);
  }
  for (const auto& [region, material] : materials) {
    if (std::find(regions.begin(), regions.end(), region) == regions.end()) {
      throw InputError(fmt::format("the mesh has no physical group \"{}\"", region),
                       fmt::format("it has {}", fmt::join(regions, ", ")));
    }
  }
  std::vector<synth::material::Material> list;
  for (const std::string& region : regions) {
    const auto found = materials.find(region);
    if (found == materials.end()) {
      throw InputError(fmt::format("physical group \"{}\" has no material", region),
                       fmt::format("add {}: NAME", region));
    }
    list.push_back(found->second);
  }
  return list;
}

void check_size(double longest, bool any_size) {
  if (any_size || (longest >= 1e-3 && longest <= 10)) return;
  throw InputError(fmt::format("the longest side is {:.6g} m, outside 1 mm to 10 m", longest),
                   longest > 10 ? "are these millimetres? Write a unit, as in 120 mm; any_size "
                                  "lets it pass"
                                : "write a unit, as in 12 mm; any_size lets it pass");
}

solvers::mesh::MeshResult shared_mesh(const solvers::mesh::MeshRequest& request,
                                      const solvers::mesher::ChildLimits& limits,
                                      const std::filesystem::path& cache, MPI_Comm comm) {
  solvers::mesh::MeshResult result;
  std::string packed;
  const bool leader = mpi::rank(comm) == 0;
  mpi::agreed(comm, [&] {
    if (!leader) return;
    result = solvers::mesher::mesh_in_child(request, limits, cache);
    if (mpi::size(comm) > 1) {
      const auto bytes = nlohmann::json::to_cbor(solvers::mesh::to_json(result));
      packed.assign(bytes.begin(), bytes.end());
    }
  });
  if (mpi::size(comm) > 1) {
    packed = mpi::broadcast(packed, 0, comm);
    mpi::agreed(comm, [&] {
      if (!leader) result = solvers::mesh::mesh_result_from_json(nlohmann::json::from_cbor(packed));
    });
  }
  return result;
}

core::Trace::Entry& mesh_entry(core::Trace& trace, const solvers::mesh::MeshRequest& request,
                               const std::filesystem::path& cache) {
  return trace.stages[solvers::mesher::mesh_is_cached(request, cache) ? "mesh from cache" : "mesh"];
}

namespace {

/// The rest of solve_object() for a body of revolution.
void solve_about_axis(const ObjectRequest& request, MPI_Comm comm,
                      const std::filesystem::path& cache, SolvedObject& object) {
  check_size(longest_side_of_turned(request.mesh.shape), request.any_size);
  object.materials = assign_materials(request.materials, {"body"});
  const solvers::basis::ModeRequest set{elastic_of(object.materials), request.solve.band};
  auto result =
      solve_turned(request.mesh.shape, std::span(&set, 1),
                   {request.solve, request.pitch_cents, request.mesh.options.element_size}, comm,
                   cache, object.trace);
  object.mesh = std::move(result.mesh);
  object.modes = std::move(result.sets.front());
  if (request.pitch_cents > 0) object.pitch_target = std::move(result.report);
}

/// @throws InputError  as nearest_point()
void check_struck(const std::vector<Vec3>& points, const solvers::modes::ModeSurface& surface) {
  if (points.empty()) return;
  const synth::modal::SurfaceSampler sampler(surface);
  for (const Vec3& point : points) nearest_point(sampler, surface, point);
}

/// What a person should know before they use an object's modes.
std::vector<std::string> warnings_of(const ObjectRequest& request, const SolvedObject& object) {
  if (request.mesh.shape.family.empty())
    return solvers::mesh::mesh_warnings(request.mesh.file, object.mesh, object.modes.mass);
  std::string bore = solvers::families::bore_warning(request.mesh.shape);
  return bore.empty() ? std::vector<std::string>() : std::vector{std::move(bore)};
}

}  // namespace

SolvedObject solve_object(const ObjectRequest& request, MPI_Comm comm,
                          const std::filesystem::path& cache) {
  // What is meshed here has one region; wrong groups need not wait for it.
  if (!gives_tetrahedra(request.mesh)) assign_materials(request.materials, {"body"});
  SolvedObject object;
  mpi::agreed(comm, [&] {
    object.solver =
        decide_solver(request.solver, request.mesh, elastic_of(listed(request.materials)));
  });
  if (object.solver.solver == ObjectSolver::axisymmetric) {
    solve_about_axis(request, comm, cache, object);
    check_struck(request.struck, object.modes.surface);
    object.warnings = warnings_of(request, object);
    return object;
  }
  solvers::eigen::SolveOptions solve = request.solve;
  const auto solve_mesh = [&](const solvers::mesh::MeshResult& mesh) {
    if (!request.mesh.shape.family.empty()) {
      check_size(solvers::mesh::bounding_box(mesh.mesh.nodes).longest_side(), request.any_size);
    }
    object.materials = assign_materials(request.materials, mesh.mesh.region_names);
    if (!request.struck.empty()) {
      std::vector<std::int32_t> nodes;
      check_struck(request.struck, solvers::eigen::surface_of(mesh.mesh, nodes));
    }
    return std::vector{solvers::eigen::cached_modes(mesh.mesh, elastic_of(object.materials), solve,
                                                    comm, cache, object.trace)};
  };
  if (request.pitch_cents != 0) {
    solve.band = solvers::pitch::judged_band(solve.band);
    const PitchSearch search{.request = request.mesh,
                             .cents = request.pitch_cents,
                             .linear_solver = solve.linear_solver,
                             .memory_limit = solve.memory_limit,
                             .max_unknowns = request.max_unknowns,
                             .limits = request.limits,
                             .cache = cache};
    auto result = refine_to_pitch(search, solve_mesh, comm, object.trace);
    object.mesh = std::move(result.mesh);
    object.modes = std::move(result.sets.front());
    object.pitch_target = std::move(result.report);
  } else {
    {
      const core::ScopedTimer timer(mesh_entry(object.trace, request.mesh, cache));
      object.mesh = shared_mesh(request.mesh, request.limits, cache, comm);
    }
    object.modes = std::move(solve_mesh(object.mesh).front());
  }
  object.warnings = warnings_of(request, object);
  return object;
}

SolvedObject in_material(const SolvedObject& object, const synth::material::Material& material,
                         double size) {
  const solvers::elements::Elastic& former = object.materials.front().elastic;
  if (object.materials.size() > 1 || material.elastic.anisotropy || former.anisotropy ||
      material.elastic.poisson_ratio != former.poisson_ratio) {
    throw InputError(
        "modes are rescaled only to another isotropic material of the same Poisson's ratio",
        "solve the object again in this material");
  }
  if (!(size > 0) || !std::isfinite(size)) {
    throw InputError(fmt::format("a size of {} is no factor of lengths", size),
                     "it must be positive");
  }
  SolvedObject changed = object;
  changed.modes = solvers::modes::rescale(object.modes, size,
                                          material.elastic.youngs_modulus / former.youngs_modulus,
                                          material.elastic.density / former.density);
  changed.materials = {material};
  return changed;
}

std::vector<solvers::elements::Elastic> elastic_of(
    const std::vector<synth::material::Material>& materials) {
  std::vector<solvers::elements::Elastic> elastic;
  for (const synth::material::Material& material : materials) elastic.push_back(material.elastic);
  return elastic;
}

std::vector<synth::damping::DampingModel> damping_of(
    const std::vector<synth::material::Material>& materials) {
  std::vector<synth::damping::DampingModel> damping;
  for (const synth::material::Material& material : materials) damping.push_back(material.damping);
  return damping;
}

}  // namespace carillon::scene
