#include "cli/object_options.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <vector>

#include "cli/command_line.hpp"
#include "cli/option_values.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "mpi/comm.hpp"
#include "scene/sounding_gltf.hpp"
#include "scene/tuned_object.hpp"
#include "solvers/mesh/readers/read_mesh.hpp"

namespace carillon::cli {

using core::Dimension;
using core::InputError;

namespace {

/// A length that was given; 0 where none was.
double positive_length(const std::string& text, const char* option) {
  if (text.empty()) return 0;
  const double length = option_quantity(text, Dimension::length, option);
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
void refuse_idle(const ObjectOptions& options) {
  if (solvers::mesh::readers::mesh_extension(options.mesh) != ".msh") return;
  const std::string why = fmt::format("the tetrahedra of {} are used as they are", options.mesh);
  refuse(!options.thickness.empty(), "--thickness", why,
         "it is the wall of open sheets in files of surfaces");
  refuse(!options.node.empty(), "--node", why, "leave it out");
  refuse(!options.element_size.empty(), "--element-size", why,
         "--order raises the order of the elements; a finer mesh is made by what made the file");
  refuse(options.edge_layers.has_value(), "--edge-layers", why,
         "--order raises the order of the elements; a finer mesh is made by what made the file");
}

/// Options that would do nothing for a generated shape.
void refuse_idle(const ObjectOptions& options, const std::string& family) {
  const std::string hint = fmt::format(
      "give the shape's own sizes, as in {}:NAME=2cm (carillon list shapes names them)", family);
  const std::string why = fmt::format("{} is generated, not read from a file", family);
  refuse(!options.length.empty(), "--length", why, hint);
  refuse(!options.unit.empty(), "--unit", why, hint);
  refuse(!options.node.empty(), "--node", why, "leave it out");
  refuse(!options.thickness.empty(), "--thickness", why, hint);
}

/// An option that only tetrahedra have a use for.
struct TetrahedralOption {
  const char* name;
  bool given;
  bool bounds;  ///< says how much a solve may take, not what comes out
};

/// The solver, and what of tetrahedra is asked for.
scene::SolverRequest solver_request(const ObjectOptions& options) {
  const std::vector<TetrahedralOption> tetrahedral = {
      {"--order", options.order.has_value(), false},
      {"--edge-layers", options.edge_layers.has_value(), false},
      {"--eigen-solver", options.eigen_solver.has_value(), false},
      {"--linear-solver", options.linear_solver.has_value(), false},
      {"--mirror-planes", options.mirror_planes.has_value(), true},
      {"--memory-limit", options.memory_limit.has_value(), true},
      {"--max-elements", options.max_elements.has_value(), true},
      {"--max-unknowns", options.max_unknowns.has_value(), true}};
  scene::SolverRequest request;
  if (options.solver) request.solver = scene::parse_object_solver(*options.solver);
  const auto belongs_to_tetrahedra = [&](const char* option) {
    if (options.solver) return;
    request = {scene::ObjectSolver::tetrahedra, fmt::format("{} is given", option)};
  };
  if (!options.element_size.empty()) belongs_to_tetrahedra("--element-size");
  for (const TetrahedralOption& option : tetrahedral) {
    if (request.solver == scene::ObjectSolver::axisymmetric)
      refuse(option.given, option.name,
             "it belongs to tetrahedra, and the axisymmetric solver has none",
             "leave it out; --element-size bounds the cells of the section");
    if (option.given && !option.bounds) belongs_to_tetrahedra(option.name);
  }
  return request;
}

solvers::eigen::SolveOptions solve_options(const ObjectOptions& options) {
  solvers::eigen::SolveOptions solve;
  solve.band.min_frequency =
      option_quantity(options.min_frequency, Dimension::frequency, "--min-frequency");
  solve.band.max_frequency = option_quantity(options.max_frequency.value_or("20 kHz"),
                                             Dimension::frequency, "--max-frequency");
  solve.band.max_modes = options.max_modes;
  if (!(solve.band.min_frequency >= 0 && solve.band.max_frequency > solve.band.min_frequency)) {
    throw InputError(fmt::format("the band from {:.6g} to {:.6g} Hz is empty",
                                 solve.band.min_frequency, solve.band.max_frequency),
                     "--min-frequency is 0 or more, and --max-frequency above it");
  }
  if (options.eigen_solver)
    solve.solver = solvers::modes::parse_eigen_solver(*options.eigen_solver);
  if (options.linear_solver) {
    solve.linear_solver = solvers::modes::parse_linear_solver(*options.linear_solver);
  }
  solve.mirror_planes = options.mirror_planes.value_or("automatic") == "automatic";
  if (options.memory_limit) {
    solve.memory_limit = core::memory_limit(*options.memory_limit, "--memory-limit");
  }
  return solve;
}

}  // namespace

void add_object_options(Command& command, ObjectOptions& options) {
  command
      .option("mesh", options.mesh,
              "OBJ, OFF, PLY, STL, glTF, DAE, FBX, 3MF, X3D, STEP, IGES, BREP or MSH file; an SVG "
              "drawing or a CSV table (radius,height) of a "
              "profile that is turned about an axis; or a generated shape such as "
              "bowl:radius=60mm,wall=3mm (carillon list shapes)")
      .required();
  command
      .option("--material,-m", options.material,
              "preset (carillon list materials), "
              "youngs_modulus=7.2e10,poisson_ratio=0.19,density=2700[,alpha1=6,alpha2=1e-7] "
              "(other damping: damping=hybrid,alpha1=...,alpha3=... or "
              "damping=6 + 1e-7*lambda; carillon list models), or group=preset,... for the "
              "physical groups of an MSH file")
      .show_default("the usual one of a family that has one, as carillon list shapes says");
  command
      .option("--first-axis", options.first_axis,
              "direction in the object of the material's first axis (of wood the grain), as x,y,z")
      .show_default("1,0,0");
  command
      .option("--second-axis", options.second_axis,
              "direction of its second axis (of wood across the rings)")
      .show_default("0,1,0, or 0,0,1 where that is the first");
  command.option("--length", options.length,
                 "longest side the object is scaled to, e.g. 0.12 m (default: as the file says)");
  command.option("--unit", options.unit, "of the file's coordinates: mm, cm, m or inch")
      .show_default("what the file says, or m");
  command.option("--node", options.node,
                 "of a file that has several, or of a CAD file's solids: this one alone (default: "
                 "all as one body; carillon inspect lists them)");
  command
      .option("--profile-axis", options.profile_axis,
              "of an SVG drawing: left or right of the outline, or x=NUMBER in its coordinates")
      .show_default("x=0, where the outline reaches it");
  command.option("--profile-id", options.profile_id,
                 "id of the drawing's outline, where it has several");
  command.option("--thickness", options.thickness, "wall given to open sheets, e.g. 2 mm");
  command.flag("--any-size", options.any_size, "let objects outside 1 mm to 10 m pass");
  command.option("--order", options.order, "order of the elements").range(1, 4).show_default("3");
  command.option("--element-size", options.element_size,
                 "largest edge, e.g. 5 mm (default: from thickness and curvature)");
  command.option("--min-frequency", options.min_frequency, "lowest frequency of the band")
      .show_default();
  command.option("--max-frequency", options.max_frequency, "highest frequency of the band")
      .show_default("20 kHz");
  command.option("--max-modes", options.max_modes, "at most so many modes")
      .range(1, 100000)
      .show_default();
  command
      .option("--solver", options.solver,
              "axisymmetric: harmonics about the axis of a generated body of revolution; "
              "tetrahedra: of any object; automatic: axisymmetric where it can be")
      .one_of({"automatic", "tetrahedra", "axisymmetric"})
      .show_default("automatic, or tetrahedra where an option of theirs is given");
  command
      .option("--eigen-solver", options.eigen_solver,
              "of tetrahedra: block_lanczos, or SLEPc's krylov_schur")
      .one_of({"block_lanczos", "krylov_schur"})
      .show_default("block_lanczos");
  command
      .option("--pitch-cents", options.pitch_cents,
              "refine order and element size until the worst mode's estimated pitch error is "
              "below it, or off; begins with --order and --element-size, and is off where these "
              "are given alone")
      .show_default("5");
  command
      .option("--max-unknowns", options.max_unknowns,
              "of refinements for --pitch-cents: those that take more are left out, and a first "
              "setting above it is solved at a lower order")
      .range(1, 1000000000)
      .show_default("120000");
  command
      .option("--edge-layers", options.edge_layers,
              "layers of thin elements at inward edges; more where --pitch-cents asks for them")
      .range(0, 4)
      .show_default("1");
  command
      .option("--linear-solver", options.linear_solver,
              "direct: Cholesky; iterative: multigrid, modes are then "
              "not counted; automatic: direct while it fits the memory limit")
      .one_of({"automatic", "direct", "iterative"})
      .show_default("automatic");
  command
      .option("--mirror-planes", options.mirror_planes,
              "automatic: where tetrahedra are exactly symmetric, the part beside the planes is "
              "solved for each class of modes; off: always the whole")
      .one_of({"automatic", "off"})
      .show_default("automatic");
  command
      .option("--memory-limit", options.memory_limit,
              "of the solve, all ranks together; decides what automatic means")
      .show_default("16 GiB");
  command
      .option("--max-elements", options.max_elements,
              "more is an error that names the element size that would fit")
      .range(1, 100000000)
      .show_default("200000");
}

bool comes_with_modes(const ObjectOptions& options) {
  return options.material.empty() && scene::has_modal_model(options.mesh);
}

void name_material(ObjectOptions& options, const Context& context) {
  if (!options.material.empty() || comes_with_modes(options)) return;
  const scene::Object object = named_object(options);
  options.material = scene::usual_material(object);
  if (options.material.empty()) {
    throw InputError(fmt::format("no material of {} is given", options.mesh),
                     "add -m NAME (carillon list materials)");
  }
  if (context.speaks() && !context.json) {
    fmt::print("material: {}, the usual one of the family {}; -m NAME takes another\n",
               options.material, object.family);
  }
}

void add_tuning_options(Command& command, ObjectOptions& options) {
  command.option("--tune", options.tune,
                 "scale the object so that its lowest mode is at a pitch, e.g. 440 Hz; lengths of "
                 "the shape's options are those before, positions on it those after");
  command
      .option("--tune-mode", options.tune_mode,
              "mode that is at the pitch, counted from the lowest")
      .range(1, 100000)
      .show_default("1");
}

/// Options of drawings.
void refuse_idle_profile(const ObjectOptions& options) {
  if (solvers::mesh::readers::mesh_extension(options.mesh) == ".svg") return;
  const std::string why = fmt::format("{} is no SVG drawing", options.mesh);
  refuse(!options.profile_axis.empty(), "--profile-axis", why,
         "a table of a profile gives radii, and the axis is where they are 0");
  refuse(!options.profile_id.empty(), "--profile-id", why, "leave it out");
}

scene::Object named_object(const ObjectOptions& options) {
  refuse_idle_profile(options);
  const double length = positive_length(options.length, "--length");
  scene::Object object = scene::parse_object(options.mesh, options.material,
                                             {options.profile_axis, options.profile_id, length});
  object.file.any_size = options.any_size;
  if (!options.first_axis.empty() || !options.second_axis.empty()) {
    const auto axis = [](const std::string& text, const char* option) {
      return text.empty() ? std::optional<Vec3>() : parse_position(text, option);
    };
    object.material_axes = scene::material_axes(axis(options.first_axis, "--first-axis"),
                                                axis(options.second_axis, "--second-axis"));
  }
  if (object.family.empty()) {
    refuse_idle(options);
    object.file.length = length;
    if (!options.node.empty()) object.nodes.names = {options.node};
    if (!options.unit.empty()) {
      object.file.unit =
          at_option("--unit", [&] { return core::parse_unit_of_length(options.unit); });
    }
    object.file.thickness = positive_length(options.thickness, "--thickness");
  } else if (object.profile_file.empty()) {
    refuse_idle(options, object.family);
  } else {
    object.file.length = length;
  }
  return object;
}

solvers::mesh::MeshRequest mesh_request(const ObjectOptions& options) {
  solvers::mesh::MeshRequest request = scene::mesh_request(named_object(options));
  request.options.order = options.order.value_or(request.options.order);
  request.options.max_elements = options.max_elements.value_or(request.options.max_elements);
  request.options.edge_layers = options.edge_layers.value_or(request.options.edge_layers);
  request.options.element_size = positive_length(options.element_size, "--element-size");
  return request;
}

scene::RegionMaterials region_materials(const ObjectOptions& options) {
  if (comes_with_modes(options)) {
    const scene::SolvedObject object = scene::read_sounding_gltf(options.mesh, options.node);
    return {{"", object.materials.front()}};
  }
  if (options.material.empty()) return {};
  return scene::region_materials(named_object(options), options.material);
}

scene::ObjectRequest object_request(const ObjectOptions& options) {
  scene::ObjectRequest request;
  request.solver = solver_request(options);
  request.mesh = mesh_request(options);
  request.materials = region_materials(options);
  request.any_size = options.any_size;
  request.solve = solve_options(options);
  request.max_unknowns = options.max_unknowns.value_or(request.max_unknowns);
  if (options.pitch_cents)
    request.pitch_cents = solvers::pitch::parse_pitch_target(*options.pitch_cents);
  else if (!options.order && options.element_size.empty())
    request.pitch_cents = solvers::pitch::usual_pitch_target;
  return request;
}

namespace {

void tell_warnings(const scene::SolvedObject& object, const ObjectOptions& options,
                   const Context& context) {
  if (!context.speaks()) return;
  for (const std::string& warning : object.warnings)
    spdlog::warn("{}: {}", options.mesh, context.chosen->in_options(warning));
}

/// The pitch to tune to, if there is one.
std::optional<scene::Tuning> tuning_of(const ObjectOptions& options) {
  if (options.tune.empty()) {
    refuse(options.tune_mode.has_value(), "--tune-mode", "there is no --tune",
           "give the pitch too, as in --tune 440Hz");
    return std::nullopt;
  }
  if (!options.length.empty()) {
    throw InputError("--length and --tune both say how large the object is", "keep one of them");
  }
  scene::Tuning tuning;
  tuning.frequency = core::parse_quantity(options.tune, Dimension::frequency);
  if (!(tuning.frequency > 0)) {
    throw InputError(fmt::format("--tune {}: a pitch is positive", options.tune),
                     "write it as 440 Hz");
  }
  tuning.mode = options.tune_mode.value_or(1);
  return tuning;
}

}  // namespace

scene::SolvedObject solve_object(const ObjectOptions& options, const Context& context,
                                 const std::optional<Vec3>& struck) {
  if (comes_with_modes(options)) {
    scene::SolvedObject object;
    mpi::agreed(context.world, [&] {
      refuse(!options.tune.empty(), "--tune", "the object comes with its modes",
             "give a material, and its mesh is solved");
      object = scene::read_sounding_gltf(options.mesh, options.node);
      scene::check_size(solvers::mesh::bounding_box(object.modes.surface.nodes).longest_side(),
                        options.any_size);
    });
    tell_warnings(object, options, context);
    return object;
  }
  scene::ObjectRequest request;
  std::optional<scene::Tuning> tuning;
  mpi::agreed(context.world, [&] {
    tuning = tuning_of(options);
    request = object_request(options);
  });
  // Of a tuned object it is meant at the size that it has then.
  if (struck && !tuning) request.struck = {*struck};
  scene::SolvedObject object =
      tuning ? scene::solve_tuned(request, *tuning, context.world, context.cache)
             : scene::solve_object(request, context.world, context.cache);
  if (tuning && context.speaks() && !context.json) {
    fmt::print("tuned to {:.6g} Hz: every length times {:.6g}, longest side {:.4g} m\n",
               tuning->frequency, object.size,
               solvers::mesh::bounding_box(object.modes.surface.nodes).longest_side());
  }
  tell_warnings(object, options, context);
  return object;
}

}  // namespace carillon::cli
