#include <fmt/format.h>

#include <algorithm>

#include "cli/body_options.hpp"
#include "cli/command_line.hpp"
#include "cli/pitch_report.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/units.hpp"
#include "dataset/exporters/gltf_document.hpp"
#include "mpi/comm.hpp"
#include "scene/material_json.hpp"
#include "solvers/eigen/extract.hpp"

namespace carillon::cli {

namespace {

using nlohmann::ordered_json;

struct GltfOptions {
  BodyOptions body;
  std::optional<int> modes;  ///< default_modes when none is given and there is a material
  double amplitude = 0.05;   ///< largest displacement over the longest side
  std::string period = "1 s";
  std::string output;
};

constexpr int default_modes = 8;

/// The surface of a body and its looks, solved only where modes are asked for.
struct ShownBody {
  scene::Body body;
  solvers::modes::ModeSurface surface;
  std::vector<std::int32_t> regions;  ///< of its faces; empty: one
};

/// @note Collective.
ShownBody shown_body(const GltfOptions& options, int modes, const Context& context) {
  ShownBody shown;
  if (modes > 0) {
    BodyOptions with_modes = options.body;
    with_modes.max_modes = modes;
    shown.body = solve_body(with_modes, context);
    shown.surface = shown.body.modes.surface;
  } else {
    solvers::mesh::MeshRequest request;
    mpi::agreed(context.world, [&] { request = mesh_request(options.body); });
    shown.body.mesh = scene::shared_mesh(request, {}, context.cache, context.world);
    const solvers::mesh::TetMesh& mesh = shown.body.mesh.mesh;
    std::vector<std::int32_t> nodes;
    mpi::agreed(context.world, [&] {
      scene::check_size(solvers::mesh::bounding_box(mesh.nodes).longest_side(),
                        options.body.any_size);
      shown.surface = solvers::eigen::surface_of(mesh, nodes);
      if (!options.body.material.empty()) {
        shown.body.materials =
            scene::assign_materials(region_materials(options.body), mesh.region_names);
      }
    });
  }
  // The axisymmetric solver has no tetrahedra, and one region.
  if (!shown.body.mesh.mesh.faces.empty())
    shown.regions = dataset::exporters::face_regions(shown.body.mesh.mesh);
  return shown;
}

/// Looks of the regions: of their materials, or grey under the regions' names.
std::vector<dataset::exporters::GltfMaterial> looks(const scene::Body& body) {
  std::vector<dataset::exporters::GltfMaterial> list;
  for (const synth::material::Material& material : body.materials) {
    list.push_back({material.name, render::appearance_of(material.name)});
  }
  if (!list.empty()) return list;
  for (const std::string& name : body.mesh.mesh.region_names) list.push_back({name, {}});
  return list;
}

/// Modes as morph targets, the largest displacement of each `reach` [m].
std::vector<dataset::exporters::GltfMode> shown_modes(
    const scene::Body& body, const dataset::exporters::GltfSurface& surface, double reach) {
  std::vector<dataset::exporters::GltfMode> list;
  if (body.modes.size() == 0) return list;
  const auto damping =
      synth::damping::clamped_decay_rates(body.modes, scene::damping_of(body.materials));
  for (std::size_t i = 0; i < body.modes.size(); ++i) {
    const Eigen::VectorXd shape =
        body.modes.shapes.row(static_cast<Eigen::Index>(i)).cast<double>();
    double largest = 0;
    for (Eigen::Index k = 0; k < shape.size(); k += 3) {
      largest = std::max(largest, shape.segment<3>(k).norm());
    }
    const double scale = largest > 0 ? reach / largest : 0;
    const double frequency = body.modes.frequency(i);
    list.push_back({fmt::format("mode {} ({:.1f} Hz)", i + 1, frequency),
                    frequency,
                    dataset::exporters::gltf_target(surface, scale * shape),
                    {{"frequency_hz", frequency},
                     {"decay_rate_per_s", damping.values[i]},
                     {"metres_per_shape", scale}}});
  }
  return list;
}

void check_options(const GltfOptions& options) {
  if (options.body.material.empty() && options.modes.value_or(0) > 0) {
    throw core::InputError("--modes needs a material", "add -m NAME (carillon list materials)");
  }
  if (!(options.amplitude > 0)) throw core::InputError("--amplitude is not positive");
  if (!(core::parse_quantity(options.period, core::Dimension::time) > 0)) {
    throw core::InputError("--period is not positive");
  }
}

dataset::exporters::GltfBody file_of(const GltfOptions& options, const ShownBody& shown) {
  dataset::exporters::GltfBody file;
  file.name = options.body.mesh;
  file.period = core::parse_quantity(options.period, core::Dimension::time);
  file.materials = looks(shown.body);
  file.surface =
      dataset::exporters::gltf_surface(shown.surface, shown.regions, file.materials.size());
  const double size = solvers::mesh::bounding_box(shown.surface.nodes).longest_side();
  file.modes = shown_modes(shown.body, file.surface, options.amplitude * size);
  file.facts["axes"] = "(x, y, z) of the body lies at (x, z, -y)";
  if (!shown.body.materials.empty()) {
    for (const synth::material::Material& material : shown.body.materials) {
      file.facts["materials"].push_back(ordered_json(scene::to_json(material)));
    }
  }
  if (shown.body.modes.size() > 0) file.facts["mass_kg"] = shown.body.modes.mass;
  return file;
}

void run_export_gltf(const GltfOptions& options, Context& context) {
  check_options(options);
  const int modes = options.modes.value_or(options.body.material.empty() ? 0 : default_modes);
  const ShownBody shown = shown_body(options, modes, context);
  settle(shown.body.pitch_target, context);
  if (!context.speaks()) return;
  const dataset::exporters::GltfBody file = file_of(options, shown);
  core::write_text_durably(options.output, dataset::exporters::gltf_bytes(file));
  const std::size_t triangles = file.surface.mesh.triangles.size();
  if (context.json) {
    fmt::print("{}\n", ordered_json{{"file", options.output},
                                    {"vertices", file.surface.nodes.size()},
                                    {"triangles", triangles},
                                    {"modes", file.modes.size()}}
                           .dump(2));
  } else {
    fmt::print("{}: {} triangles, {} modes\n", options.output, triangles, file.modes.size());
  }
}

}  // namespace

void add_export_gltf(Program& program, Context& context) {
  Command& command = program.add(
      "export-gltf", "a body as a model for pictures and games, with its modes: binary glTF",
      Needs::solver);
  auto options = std::make_shared<GltfOptions>();
  add_body_options(command, options->body);
  command.option_named("--material").required(false);
  command.remove("--max-modes");
  command.option("-o,--output", options->output, "file, .glb").required();
  command
      .option("--modes", options->modes,
              "at most so many, the lowest: a morph target and an animation each; pairs are "
              "kept whole")
      .show_default(fmt::format("{} with a material", default_modes))
      .range(0, 1000);
  command
      .option("--amplitude", options->amplitude,
              "largest displacement at a weight of 1, over the longest side")
      .show_default();
  command.option("--period", options->period, "that each mode swings with when shown")
      .show_default();
  command.footer(
      "Examples:\n"
      "  carillon export-gltf bowl -m ceramic -o bowl.glb\n"
      "  carillon export-gltf cup.obj --length 10cm -o cup.glb\n"
      "docs/exports.md");
  command.does([&context, options] { run_export_gltf(*options, context); });
}

}  // namespace carillon::cli
