#include "scene/body.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "mpi/comm.hpp"
#include "scene/detail/turned_body.hpp"
#include "scene/pitch.hpp"
#include "solvers/eigen/cached_modes.hpp"
#include "solvers/families/families.hpp"
#include "solvers/mesh/readers/read_mesh.hpp"

namespace carillon::scene {

using core::Dimension;
using core::InputError;

namespace {

solvers::mesh::GeneratedShape parse_shape(const std::string& family_name,
                                          const std::string& values) {
  const solvers::families::Family& family = solvers::families::find_family(family_name);
  solvers::mesh::GeneratedShape shape{.family = family.name, .parameters = {}, .profile = {}};
  std::vector<std::string> names;
  for (const solvers::families::FamilyParameter& parameter : family.parameters) {
    shape.parameters[parameter.name] = 0.5 * (parameter.low + parameter.high);
    names.push_back(parameter.name);
  }
  for (const auto& [key, value] : core::parse_assignments(values)) {
    if (!shape.parameters.contains(key)) {
      const std::string near = core::nearest_name(key, names);
      throw InputError(fmt::format("{} has no parameter \"{}\"", family.name, key),
                       near.empty() ? fmt::format("it has {}", fmt::join(names, ", "))
                                    : fmt::format("did you mean \"{}\"?", near));
    }
    shape.parameters[key] = core::parse_quantity(value, Dimension::length);
  }
  family.check(shape);
  return shape;
}

/// A length that was given; 0 where none was.
double positive_length(const std::string& text, const char* option) {
  if (text.empty()) return 0;
  const double length = core::parse_quantity(text, Dimension::length);
  if (!(length > 0)) {
    throw InputError(fmt::format("{} {}: a length is positive", option, text),
                     "leave the option out to have it chosen");
  }
  return length;
}

void refuse(bool given, const char* option, const std::string& why, const std::string& hint) {
  if (given) throw InputError(fmt::format("{} does not apply: {}", option, why), hint);
}

/// Options that would do nothing for a file.
void refuse_idle(const BodyOptions& options) {
  if (solvers::mesh::readers::mesh_extension(options.mesh) != ".msh") return;
  const std::string why = fmt::format("the tetrahedra of {} are used as they are", options.mesh);
  refuse(!options.thickness.empty(), "--thickness", why,
         "it is the wall of open sheets in OBJ, OFF, PLY and STL files");
  refuse(!options.element_size.empty(), "--element-size", why,
         "--order raises the order of the elements; a finer mesh is made by what made the file");
}

/// Options that would do nothing for a generated shape.
void refuse_idle(const BodyOptions& options, const std::string& family) {
  const std::string hint = fmt::format(
      "give the shape's own sizes, as in {}:NAME=2cm (carillon list shapes names them)", family);
  const std::string why = fmt::format("{} is generated, not read from a file", family);
  refuse(!options.length.empty(), "--length", why, hint);
  refuse(!options.thickness.empty(), "--thickness", why, hint);
}

}  // namespace

void refuse_tetrahedral_options(const BodyOptions& options) {
  const std::string why = "it belongs to tetrahedra, and the fourier solver has none";
  const std::string hint = "leave it out; --element-size bounds the cells of the section";
  refuse(options.order.has_value(), "--order", why, hint);
  refuse(options.linear_solver.has_value(), "--linear-solver", why, hint);
  refuse(options.memory_limit.has_value(), "--memory-limit", why, hint);
  refuse(options.max_elements.has_value(), "--max-elements", why, hint);
  refuse(options.pitch_cents != 0, "--pitch-cents", why,
         "leave it out; the fourier solver comes within 0.01 cents by itself");
}

solvers::mesh::MeshRequest mesh_request(const BodyOptions& options) {
  solvers::mesh::MeshRequest request;
  request.options.order = options.order.value_or(request.options.order);
  request.options.max_elements = options.max_elements.value_or(request.options.max_elements);
  request.options.element_size = positive_length(options.element_size, "--element-size");
  if (std::filesystem::exists(options.mesh)) {
    refuse_idle(options);
    request.file.path = options.mesh;
    request.file.any_size = options.any_size;
    request.file.length = positive_length(options.length, "--length");
    request.file.thickness = positive_length(options.thickness, "--thickness");
    return request;
  }
  const auto colon = options.mesh.find(':');
  const std::string family = options.mesh.substr(0, colon);
  if (family.find_first_of("./\\") != std::string::npos) {
    throw core::FileError(fmt::format("{}: no such file", options.mesh));
  }
  refuse_idle(options, family);
  request.shape =
      parse_shape(family, colon == std::string::npos ? "" : options.mesh.substr(colon + 1));
  return request;
}

std::vector<synth::material::Material> assign_materials(
    const std::map<std::string, std::string>& groups, const std::vector<std::string>& regions,
    const std::vector<synth::material::Material>& own) {
  for (const auto& [group, name] : groups) {
    if (std::find(regions.begin(), regions.end(), group) == regions.end()) {
      throw InputError(fmt::format("the mesh has no physical group \"{}\"", group),
                       fmt::format("it has {}", fmt::join(regions, ", ")));
    }
  }
  std::vector<synth::material::Material> materials;
  for (const std::string& region : regions) {
    const auto found = groups.find(region);
    if (found == groups.end()) {
      throw InputError(fmt::format("physical group \"{}\" has no material", region),
                       fmt::format("add {}: NAME", region));
    }
    materials.push_back(synth::material::parse_material(found->second, own));
  }
  return materials;
}

namespace {

/// Names of `shell=steel,core=wood` by group; empty for one material.
std::map<std::string, std::string> materials_by_group(const std::string& text) {
  std::map<std::string, std::string> groups;
  if (text.find('=') == std::string::npos || text.find("youngs_modulus") != std::string::npos) {
    return groups;
  }
  for (const auto& [group, name] : core::parse_assignments(text)) groups[group] = name;
  return groups;
}

}  // namespace

std::vector<synth::material::Material> region_materials(const std::string& text,
                                                        const std::vector<std::string>& regions) {
  const auto groups = materials_by_group(text);
  if (!groups.empty()) return assign_materials(groups, regions, {});
  return std::vector<synth::material::Material>(regions.size(),
                                                synth::material::parse_material(text));
}

std::vector<synth::material::Material> named_materials(const std::string& text) {
  const auto groups = materials_by_group(text);
  if (groups.empty()) return {synth::material::parse_material(text)};
  std::vector<synth::material::Material> materials;
  for (const auto& [group, name] : groups)
    materials.push_back(synth::material::parse_material(name));
  return materials;
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

solvers::eigen::SolveOptions solve_options(const BodyOptions& options) {
  solvers::eigen::SolveOptions solve;
  solve.band.min_frequency = core::parse_quantity(options.min_frequency, Dimension::frequency);
  solve.band.max_frequency =
      core::parse_quantity(options.max_frequency.value_or("20 kHz"), Dimension::frequency);
  solve.band.max_modes = options.max_modes;
  if (!(solve.band.min_frequency >= 0 && solve.band.max_frequency > solve.band.min_frequency)) {
    throw InputError("the band is empty", "--max-frequency must be above --min-frequency");
  }
  if (options.solver == "krylov_schur") solve.solver = solvers::modes::EigenSolver::krylov_schur;
  if (options.linear_solver) {
    solve.linear_solver = solvers::modes::parse_linear_solver(*options.linear_solver);
  }
  if (options.memory_limit) {
    solve.memory_limit = core::memory_limit(*options.memory_limit, "--memory-limit");
  }
  return solve;
}

Body solve_body(const BodyOptions& options, const mpi::Context& context) {
  if (options.solver == "fourier") return solve_turned(options, context);
  Body body;
  solvers::mesh::MeshRequest request;
  mpi::agreed(context.world, [&] { request = mesh_request(options); });
  solvers::eigen::SolveOptions solve = solve_options(options);
  const auto solve_mesh = [&](const solvers::mesh::MeshResult& mesh) {
    if (!request.shape.family.empty()) {
      check_size(solvers::mesh::bounding_box(mesh.mesh.nodes).longest_side(), options.any_size);
    }
    body.materials = region_materials(options.material, mesh.mesh.region_names);
    return std::vector{solvers::eigen::cached_modes(mesh.mesh, elastic_of(body.materials), solve,
                                                    context.world, context.cache, body.trace)};
  };
  if (options.pitch_cents != 0) {
    solve.band = solvers::pitch::judged_band(solve.band);
    const PitchSearch search{.request = request,
                             .cents = options.pitch_cents,
                             .linear_solver = solve.linear_solver,
                             .memory_limit = solve.memory_limit,
                             .limits = {},
                             .cache = context.cache};
    auto result = refine_to_pitch(search, solve_mesh, context.world, body.trace);
    body.mesh = std::move(result.mesh);
    body.modes = std::move(result.sets.front());
    body.pitch_target = std::move(result.report);
  } else {
    {
      const core::ScopedTimer timer(mesh_entry(body.trace, request, context.cache));
      body.mesh = shared_mesh(request, {}, context.cache, context.world);
    }
    body.modes = std::move(solve_mesh(body.mesh).front());
  }
  return body;
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
