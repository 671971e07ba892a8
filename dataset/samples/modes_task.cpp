#include "dataset/samples/modes_task.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hdf5.hpp"
#include "core/storage_error.hpp"
#include "dataset/samples/detail/object_views.hpp"
#include "dataset/samples/detail/tuned_sets.hpp"
#include "dataset/samples/shape_modes.hpp"
#include "mpi/comm.hpp"
#include "scene/pitch.hpp"
#include "scene/solved_object.hpp"
#include "scene/turned_sets.hpp"
#include "solvers/families/families.hpp"
#include "solvers/mesh/mesh_warnings.hpp"
#include "solvers/modes/modes_file.hpp"
#include "synth/motion/convex_hull.hpp"

namespace carillon::dataset::samples {

using solvers::elements::Elastic;

namespace {

/// Two objects with these regions have the same dimensionless modes.
bool same_set(const std::vector<Elastic>& a, const std::vector<Elastic>& b) {
  const auto close = [](double x, double y) { return std::abs(x - y) <= 1e-12 * std::abs(y); };
  for (std::size_t r = 0; r < a.size(); ++r) {
    if (!same_law(a[r], b[r])) return false;
    if (!close(a[r].youngs_modulus * b[0].youngs_modulus,
               b[r].youngs_modulus * a[0].youngs_modulus) ||
        !close(a[r].density * b[0].density, b[r].density * a[0].density)) {
      return false;
    }
  }
  return true;
}

/// Longest time a wave takes per unit of the object's own length: frequencies scale with its
/// inverse.
double slowness(const Elastic& elastic, double size) {
  return size * std::sqrt(elastic.density / elastic.youngs_modulus);
}

/// The request that makes the mesh of a result: the first setting of a shape, or the one that a
/// pitch target ended with.
solvers::mesh::MeshRequest final_request(const plan::Shape& shape,
                                         const solvers::pitch::PitchReport& report) {
  solvers::mesh::MeshRequest request = shape.request;
  if (report.steps.empty()) return request;
  const solvers::pitch::PitchStep& step = report.steps[report.chosen];
  request.options.order = step.order;
  request.options.element_size = step.automatic_size ? 0 : step.element_size;
  request.options.edge_layers = step.edge_layers;
  return request;
}

void write_shape(const plan::Shape& shape, const solvers::mesh::MeshRequest& request,
                 const solvers::mesh::MeshResult& mesh, const core::Hdf5Group& file) {
  file.write_attribute("shape", shape.id);
  file.write_attribute("family", shape.family);
  file.write_attribute("request", solvers::mesh::to_json(request).dump());
  file.write_attribute("solver", nlohmann::json({{"name", scene::name_of(shape.solver.solver)},
                                                 {"reason", shape.solver.reason}})
                                     .dump());
  if (shape.solver.solver == scene::ObjectSolver::tetrahedra)
    file.write_attribute("quality", solvers::mesh::to_json(mesh.quality).dump());
  if (!shape.path.empty()) {
    file.write_attribute("diagnosis", solvers::mesh::to_json(mesh.diagnosis).dump());
    file.write_attribute("repair", solvers::mesh::to_json(mesh.repair).dump());
  }
  file.write<std::string>("regions", mesh.mesh.region_names, {mesh.mesh.region_names.size()});
}

/// What Bullet needs of a body. One that was solved about its axis gets straight tetrahedra here.
void write_body(const configuration::BuildConfig& config, const plan::Shape& shape,
                const solvers::mesh::TetMesh& solved, const BuildFolders& folders,
                const core::Hdf5Group& file, core::Trace& trace) {
  solvers::mesh::TetMesh straight;
  if (shape.solver.solver == scene::ObjectSolver::axisymmetric) {
    solvers::mesh::MeshRequest request = shape.request;
    request.options.order = 1;
    const core::ScopedTimer timer(scene::mesh_entry(trace, request, folders.cache));
    straight = solvers::mesher::mesh_in_child(request, config.limits.mesh, folders.cache).mesh;
  }
  const solvers::mesh::TetMesh& mesh = straight.nodes.empty() ? solved : straight;
  const core::ScopedTimer timer(trace.stages["convex pieces"]);
  write_hulls(file, synth::motion::convex_pieces(mesh));
  if (mesh.region_names.size() > 1) write_moments(file, synth::surface::region_moments(mesh));
}

}  // namespace

std::filesystem::path BuildFolders::modes_file(const plan::Shape& shape) const {
  return output / "modes" / (shape.id + ".h5");
}

std::filesystem::path BuildFolders::shard_file(const plan::BuildTask& task) const {
  return output / (task.key + ".h5");
}

double frequency_factor(const VariantModes& variant) {
  return std::sqrt(variant.modulus / variant.density) / variant.length;
}

ModeSets group_variants(const std::vector<std::vector<synth::material::Material>>& materials,
                        const std::vector<plan::Variant>& variants,
                        const solvers::modes::Band& band) {
  ModeSets sets;
  std::vector<double> slowest, fastest;
  sets.variants.resize(variants.size());
  for (std::size_t v = 0; v < variants.size(); ++v) {
    const std::vector<Elastic> regions = scene::elastic_of(materials[v]);
    const double slow = slowness(regions[0], variants[v].size);
    std::size_t s = 0;
    while (s < sets.requests.size() && !same_set(regions, sets.requests[s].regions)) ++s;
    if (s == sets.requests.size()) {
      sets.requests.push_back({regions, band});
      slowest.push_back(slow);
      fastest.push_back(slow);
    }
    // The slowest variant has the most modes in the band: its set serves the others.
    constexpr double rounding = 1e-12;  // tuned to one pitch in two materials, both are as slow
    if (slow > slowest[s] * (1 + rounding)) sets.requests[s].regions = regions;
    slowest[s] = std::max(slowest[s], slow);
    fastest[s] = std::min(fastest[s], slow);
    sets.variants[v].set = s;
  }
  for (std::size_t s = 0; s < sets.requests.size(); ++s) {
    const double own = slowness(sets.requests[s].regions[0], 1);
    sets.requests[s].band = {band.min_frequency * fastest[s] / own,
                             band.max_frequency * slowest[s] / own, band.max_modes,
                             band.min_frequency * slowest[s] / own};
  }
  for (std::size_t v = 0; v < variants.size(); ++v) {
    VariantModes& variant = sets.variants[v];
    const Elastic& solved = sets.requests[variant.set].regions[0];
    const Elastic& wanted = materials[v][0].elastic;
    variant.length = variants[v].size;
    variant.modulus = wanted.youngs_modulus / solved.youngs_modulus;
    variant.density = wanted.density / solved.density;
  }
  return sets;
}

namespace {

/// What the variants of a shape ask for.
/// @param longest  its longest side [m]
/// @throws InputError  a variant of a size that is a slip, or regions without a material
ModeSets wanted_sets(const configuration::BuildConfig& config, const plan::Shape& shape,
                     const solvers::modes::Band& band, double longest,
                     const std::vector<std::string>& regions) {
  std::vector<std::vector<synth::material::Material>> materials;
  for (const plan::Variant& variant : shape.variants) {
    scene::check_size(longest * variant.size, config.objects[shape.source].object.file.any_size);
    materials.push_back(plan::variant_materials(config, shape, variant, regions));
  }
  return group_variants(materials, shape.variants, band);
}

/// Solves the mode sets of meshes that serve every variant of a shape.
class SetsOfMeshes {
 public:
  SetsOfMeshes(const configuration::BuildConfig& config, const plan::Shape& shape,
               const solvers::modes::Band& band, const BuildFolders& folders, MPI_Comm comm,
               core::Trace& trace)
      : config_(config),
        shape_(shape),
        band_(band),
        folders_(folders),
        comm_(comm),
        trace_(trace) {}

  /// All sets of a mesh.
  std::vector<solvers::modes::Modes> all(const solvers::mesh::MeshResult& mesh) {
    auto requests = requests_of(mesh);
    if (!was_probed(mesh)) return solve(mesh, requests);
    const auto probed = static_cast<std::ptrdiff_t>(hardest(requests));
    requests.erase(requests.begin() + probed);
    auto sets = solve(mesh, requests);
    sets.insert(sets.begin() + probed, probed_set_);
    return sets;
  }

  /// The set of the slowest waves alone: that with the most modes, whose last ones are the
  /// shortest beside the elements.
  std::vector<solvers::modes::Modes> probe(const solvers::mesh::MeshResult& mesh) {
    const auto requests = requests_of(mesh);
    auto sets = solve(mesh, std::span(requests).subspan(hardest(requests), 1));
    probed_set_ = sets.front();
    probed_order_ = mesh.mesh.order;
    probed_nodes_ = mesh.mesh.nodes;
    return sets;
  }

 private:
  using Requests = std::vector<solvers::basis::ModeRequest>;

  Requests requests_of(const solvers::mesh::MeshResult& mesh) const {
    const double longest = solvers::mesh::bounding_box(mesh.mesh.nodes).longest_side();
    Requests requests =
        wanted_sets(config_, shape_, band_, longest, mesh.mesh.region_names).requests;
    if (config_.pitch_cents > 0) {
      for (auto& request : requests) request.band = solvers::pitch::judged_band(request.band);
    }
    return requests;
  }

  static std::size_t hardest(const Requests& requests) {
    const auto last = [](const solvers::basis::ModeRequest& request) {
      return request.band.max_frequency * slowness(request.regions[0], 1);
    };
    const auto found = std::max_element(
        requests.begin(), requests.end(),
        [&](const auto& one, const auto& other) { return last(one) < last(other); });
    return static_cast<std::size_t>(found - requests.begin());
  }

  bool was_probed(const solvers::mesh::MeshResult& mesh) const {
    return mesh.mesh.order == probed_order_ && mesh.mesh.nodes == probed_nodes_;
  }

  std::vector<solvers::modes::Modes> solve(
      const solvers::mesh::MeshResult& mesh,
      std::span<const solvers::basis::ModeRequest> requests) const {
    solvers::eigen::SolveOptions options = config_.solver;
    options.time = configuration::solve_clock(config_.limits);
    std::vector<solvers::modes::Modes> solved;
    configuration::within_memory(config_.limits.solve_memory, [&] {
      solved = solvers::basis::solve_materials(mesh.mesh, requests, options, comm_, folders_.cache,
                                               trace_);
    });
    return solved;
  }

  const configuration::BuildConfig& config_;
  const plan::Shape& shape_;
  const solvers::modes::Band band_;
  const BuildFolders& folders_;
  MPI_Comm comm_;
  core::Trace& trace_;
  solvers::modes::Modes probed_set_;
  int probed_order_ = 0;
  std::vector<Vec3> probed_nodes_;
};

/// Mesh and mode sets as the configuration asks: as they come, or refined to a pitch target.
solvers::pitch::PitchResult make_sets(const configuration::BuildConfig& config,
                                      const plan::Shape& shape, const solvers::modes::Band& band,
                                      const BuildFolders& folders, MPI_Comm comm,
                                      core::Trace& trace) {
  if (shape.solver.solver == scene::ObjectSolver::axisymmetric) {
    trace.enter("solve");
    const solvers::mesh::GeneratedShape& turned = shape.request.shape;
    const ModeSets sets =
        wanted_sets(config, shape, band, scene::longest_side_of_turned(turned), {"body"});
    scene::TurnedOptions options{config.solver, config.pitch_cents, 0};
    options.solve.time = configuration::solve_clock(config.limits);
    solvers::pitch::PitchResult solved;
    configuration::within_memory(config.limits.solve_memory, [&] {
      solved = scene::solve_turned(turned, sets.requests, options, comm, folders.cache, trace);
    });
    return solved;
  }
  trace.enter("mesh");
  SetsOfMeshes sets_of(config, shape, band, folders, comm, trace);
  const auto solve = [&](const solvers::mesh::MeshResult& mesh) {
    trace.enter("solve");
    std::vector<solvers::modes::Modes> sets = sets_of.all(mesh);
    trace.enter("mesh");  // a finer one, unless this was the last
    return sets;
  };
  scene::SetSolver probe;
  if (shape.variants.size() > 1) {
    probe = [&](const solvers::mesh::MeshResult& mesh) {
      trace.enter("solve");
      std::vector<solvers::modes::Modes> sets = sets_of.probe(mesh);
      trace.enter("mesh");
      return sets;
    };
  }
  if (config.pitch_cents > 0) {
    scene::PitchSearch search;
    search.request = shape.request;
    search.cents = config.pitch_cents;
    search.linear_solver = config.solver.linear_solver;
    search.memory_limit = config.solver.memory_limit;
    search.max_unknowns = config.max_unknowns;
    search.limits = config.limits.mesh;
    search.cache = folders.cache;
    return scene::refine_to_pitch(search, solve, comm, trace, probe);
  }
  solvers::pitch::PitchResult result;
  {
    const core::ScopedTimer timer(scene::mesh_entry(trace, shape.request, folders.cache));
    result.mesh = scene::shared_mesh(shape.request, config.limits.mesh, folders.cache, comm);
  }
  result.sets = solve(result.mesh);
  return result;
}

/// The same, of a tuned shape with the sizes that its variants get; what is wrong with a manifest's
/// file names its row.
solvers::pitch::PitchResult make_placed_sets(const configuration::BuildConfig& config,
                                             plan::Shape& shape, const BuildFolders& folders,
                                             MPI_Comm comm, core::Trace& trace) {
  const auto placed = [&shape](const core::Error& error) {
    return shape.place.empty() ? error.message()
                               : fmt::format("{}: {}", shape.place, error.message());
  };
  try {
    if (!is_tuned(shape)) return make_sets(config, shape, config.band, folders, comm, trace);
    const auto at_sizes = [&](const plan::Shape& sized, const solvers::modes::Band& band) {
      return make_sets(config, sized, band, folders, comm, trace);
    };
    return make_tuned_sets(config, folders, comm, trace, at_sizes, shape);
  } catch (const core::StorageError&) {
    throw;
  } catch (const core::InputError& error) {
    throw core::InputError(placed(error), error.hint());
  } catch (const core::FileError& error) {
    throw core::FileError(placed(error), error.hint());
  }
}

}  // namespace

ModesTaskResult run_modes_task(const configuration::BuildConfig& config, const plan::Shape& planned,
                               const BuildFolders& folders, MPI_Comm comm, core::Trace& trace) {
  plan::Shape shape = planned;
  const solvers::pitch::PitchResult made = make_placed_sets(config, shape, folders, comm, trace);
  const std::vector<solvers::modes::Modes>& modes = made.sets;
  const solvers::mesh::MeshRequest request = final_request(shape, made.report);
  ModesTaskResult result;
  if (config.pitch_cents > 0) {
    result.pitch_target = {{"asked_cents", made.report.asked_cents},
                           {"reached_cents", made.report.reached_cents},
                           {"met", made.report.met()}};
    if (shape.solver.solver == scene::ObjectSolver::tetrahedra) {
      result.pitch_target["order"] = request.options.order;
      result.pitch_target["element_size_m"] = request.options.element_size;
    }
  }
  if (!shape.path.empty())
    result.warnings = solvers::mesh::mesh_warnings(request.file, made.mesh, modes.front().mass);
  if (std::string bore = solvers::families::bore_warning(shape.request.shape); !bore.empty())
    result.warnings.push_back(std::move(bore));
  if (config.pitch_cents > 0 && !made.report.met())
    result.warnings.push_back(fmt::format("{:.3g} cents instead of {:.3g}: {}",
                                          made.report.reached_cents, made.report.asked_cents,
                                          made.report.reason));
  if (mpi::rank(comm) == 0)
    for (const std::string& warning : result.warnings) spdlog::warn("{}: {}", shape.id, warning);
  trace.enter("write");
  mpi::agreed(comm, [&] {
    if (mpi::rank(comm) != 0) return;
    core::write_durably(folders.modes_file(shape), [&](const std::filesystem::path& path) {
      const core::Hdf5Group file = core::Hdf5Group::create_file(path);
      write_shape(shape, request, made.mesh, file);
      if (config.pitch_cents > 0) {
        file.write_attribute("pitch_target", solvers::pitch::to_json(made.report, false).dump());
      }
      for (std::size_t s = 0; s < modes.size(); ++s) {
        solvers::modes::write_modes(file.create_group(fmt::format("set-{:03}", s)), modes[s]);
      }
      if (is_tuned(shape)) write_tuned_sizes(file, shape);
      if (config.motion) write_body(config, shape, made.mesh.mesh, folders, file, trace);
      write_views(config, shape, made.mesh.mesh, modes.front().surface, folders, file, trace,
                  result.written);
      file.flush();
    });
    result.written.push_back(
        std::filesystem::relative(folders.modes_file(shape), folders.output).string());
  });
  return result;
}

}  // namespace carillon::dataset::samples
