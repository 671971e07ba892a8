#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "cli/command_line.hpp"
#include "cli/object_options.hpp"
#include "cli/option_values.hpp"
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
  ObjectOptions object;
  std::optional<int> modes;  ///< default_modes when none is given and there is a material
  int audio_modes = 60;
  std::string audio_points = "corners";
  double amplitude = 0.05;  ///< largest displacement over the longest side
  std::string period = "1 s";
  std::string output;
};

constexpr int default_modes = 8;

/// The surface of an object and its looks, solved only where modes are asked for.
struct ShownObject {
  scene::SolvedObject object;
  solvers::modes::ModeSurface surface;
  std::vector<std::int32_t> regions;  ///< of its faces; empty: one
};

/// @note Collective.
ShownObject shown_object(const GltfOptions& options, int modes, const Context& context) {
  ShownObject shown;
  if (modes > 0) {
    ObjectOptions with_modes = options.object;
    with_modes.max_modes = std::max(modes, options.audio_modes);
    shown.object = solve_object(with_modes, context);
    shown.surface = shown.object.modes.surface;
  } else {
    solvers::mesh::MeshRequest request;
    mpi::agreed(context.world, [&] { request = mesh_request(options.object); });
    shown.object.mesh = scene::shared_mesh(request, {}, context.cache, context.world);
    const solvers::mesh::TetMesh& mesh = shown.object.mesh.mesh;
    std::vector<std::int32_t> nodes;
    mpi::agreed(context.world, [&] {
      scene::check_size(solvers::mesh::bounding_box(mesh.nodes).longest_side(),
                        options.object.any_size);
      shown.surface = solvers::eigen::surface_of(mesh, nodes);
      if (!options.object.material.empty()) {
        shown.object.materials =
            scene::assign_materials(region_materials(options.object), mesh.region_names);
      }
    });
  }
  // The axisymmetric solver has no tetrahedra, and one region.
  if (!shown.object.mesh.mesh.faces.empty())
    shown.regions = solvers::mesh::face_regions(shown.object.mesh.mesh);
  return shown;
}

/// Looks of the regions: of their materials, or grey under the regions' names.
std::vector<dataset::exporters::GltfMaterial> looks(const scene::SolvedObject& object) {
  std::vector<dataset::exporters::GltfMaterial> list;
  for (const synth::material::Material& material : object.materials) {
    list.push_back({material.name, synth::material::appearance_of(material)});
  }
  if (!list.empty()) return list;
  for (const std::string& name : object.mesh.mesh.region_names) list.push_back({name, {}});
  return list;
}

/// Modes as morph targets, the largest displacement of each `reach` [m].
std::vector<dataset::exporters::GltfMode> shown_modes(
    const scene::SolvedObject& object, const dataset::exporters::GltfSurface& surface, int modes,
    double reach) {
  std::vector<dataset::exporters::GltfMode> list;
  if (object.modes.size() == 0) return list;
  const std::size_t shown =
      solvers::modes::whole_clusters(object.modes.eigenvalues, static_cast<std::size_t>(modes));
  const auto damping =
      synth::damping::clamped_decay_rates(object.modes, scene::damping_of(object.materials));
  for (std::size_t i = 0; i < shown; ++i) {
    const Eigen::VectorXd shape = object.modes.shapes.of(static_cast<Eigen::Index>(i));
    double largest = 0;
    for (Eigen::Index k = 0; k < shape.size(); k += 3) {
      largest = std::max(largest, shape.segment<3>(k).norm());
    }
    const double scale = largest > 0 ? reach / largest : 0;
    const double frequency = object.modes.frequency(i);
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
  if (!(options.amplitude > 0)) throw core::InputError("--amplitude is not positive");
  if (!(option_quantity(options.period, core::Dimension::time, "--period") > 0)) {
    throw core::InputError("--period is not positive");
  }
}

/// The modal model of at most so many modes; none where there are no modes.
std::optional<dataset::exporters::GltfAudio> audio_of(const GltfOptions& options,
                                                      const scene::SolvedObject& object) {
  if (options.audio_modes == 0 || object.modes.size() == 0) return std::nullopt;
  solvers::modes::Band band = {0, std::numeric_limits<double>::infinity(), options.audio_modes};
  const solvers::modes::Modes modes = solvers::modes::restrict_to(object.modes, band);
  const auto damping =
      synth::damping::clamped_decay_rates(modes, scene::damping_of(object.materials));
  const solvers::mesh::TetMesh& mesh = object.mesh.mesh;
  std::vector<double> densities;
  for (const synth::material::Material& material : object.materials)
    densities.push_back(material.elastic.density);
  const synth::surface::RigidBody rigid =
      densities.size() > 1
          ? synth::surface::rigid_body(synth::surface::region_moments(mesh), densities, modes.mass)
          : synth::surface::rigid_body(modes);
  return dataset::exporters::gltf_audio(modes, damping.values, object.materials, rigid,
                                        options.audio_points == "nodes"
                                            ? dataset::exporters::AudioPoints::nodes
                                            : dataset::exporters::AudioPoints::corners);
}

dataset::exporters::GltfObject file_of(const GltfOptions& options, int modes,
                                       const ShownObject& shown) {
  dataset::exporters::GltfObject file;
  file.name = options.object.mesh;
  file.period = core::parse_quantity(options.period, core::Dimension::time);
  file.materials = looks(shown.object);
  file.surface =
      dataset::exporters::gltf_surface(shown.surface, shown.regions, file.materials.size());
  const double size = solvers::mesh::bounding_box(shown.surface.nodes).longest_side();
  file.modes = shown_modes(shown.object, file.surface, modes, options.amplitude * size);
  file.audio = audio_of(options, shown.object);
  file.facts["axes"] = "(x, y, z) of the object lies at (x, z, -y)";
  if (!shown.object.materials.empty()) {
    for (const synth::material::Material& material : shown.object.materials) {
      file.facts["materials"].push_back(ordered_json(scene::to_json(material)));
    }
  }
  if (shown.object.modes.size() > 0) file.facts["mass_kg"] = shown.object.modes.mass;
  return file;
}

void run_export_gltf(GltfOptions options, Context& context) {
  check_options(options);
  const bool with_modes = comes_with_modes(options.object);
  if (options.modes.value_or(0) > 0) name_material(options.object, context);
  const int modes =
      options.modes.value_or(options.object.material.empty() && !with_modes ? 0 : default_modes);
  require_output_file(context, options.output);
  const ShownObject shown = shown_object(options, modes, context);
  settle(options.object, shown.object.pitch_target, context);
  if (!context.speaks()) return;
  const dataset::exporters::GltfObject file = file_of(options, modes, shown);
  core::write_text_durably(options.output, dataset::exporters::gltf_bytes(file));
  const std::size_t triangles = file.surface.mesh.triangles.size();
  const std::size_t sounding = file.audio ? file.audio->frequencies.size() : 0;
  if (context.json) {
    fmt::print("{}\n", ordered_json{{"file", options.output},
                                    {"vertices", file.surface.nodes.size()},
                                    {"triangles", triangles},
                                    {"modes", file.modes.size()},
                                    {"audio_modes", sounding},
                                    {"audio_points", file.audio ? file.audio->positions.size() : 0}}
                           .dump(2));
  } else {
    fmt::print("{}: {} triangles, {} modes shown, {} modes that sound\n", options.output, triangles,
               file.modes.size(), sounding);
  }
}

}  // namespace

void add_export_gltf(Program& program, Context& context) {
  Command& command = program.add(
      "export-gltf",
      "an object as a model for pictures and games, with its modes and its sound: binary glTF",
      Needs::solver);
  auto options = std::make_shared<GltfOptions>();
  add_object_options(command, options->object);
  add_tuning_options(command, options->object);
  command.option_named("--material").show_default("none: a grey surface without modes");
  command.remove("--max-modes");
  command.option("-o,--output", options->output, "file, .glb").required();
  command
      .option("--modes", options->modes,
              "at most so many, the lowest: a morph target and an animation each; pairs are "
              "kept whole")
      .show_default(fmt::format("{} with a material", default_modes))
      .range(0, 1000);
  command
      .option("--audio-modes", options->audio_modes,
              "at most so many, the lowest, in the file's modal model (KHR_audio_rigid_bodies), "
              "which games and carillon strike play; 0: none")
      .range(0, 100000)
      .show_default();
  command
      .option("--audio-points", options->audio_points,
              "where its mode shapes are sampled: at the corners of the surface's faces, or at all "
              "nodes (a few times as many)")
      .one_of({"corners", "nodes"})
      .show_default();
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
