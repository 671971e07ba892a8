#include "dataset/configuration/configuration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <numbers>
#include <set>

#include "core/error.hpp"
#include "core/folder_name.hpp"
#include "core/text.hpp"
#include "dataset/configuration/detail/negative_damping.hpp"
#include "dataset/configuration/detail/view_costs.hpp"
#include "scene/picture.hpp"
#include "solvers/families/families.hpp"
#include "solvers/pitch/pitch_target.hpp"

namespace carillon::dataset::configuration {

using core::at_key;
using core::ConfigNode;
using core::Dimension;
using core::path_beside;

namespace {

/// The hop and how many frames are kept.
void read_frames(ConfigNode& node, std::int64_t samples, synth::signal::MelOptions& mel) {
  if (node.has("overlap")) {
    if (node.has("hop")) node.fail("hop", "follows from `overlap`: give one of them");
    const double overlap = node.quantity("overlap", Dimension::none);
    if (!(overlap >= 0 && overlap < 1)) node.fail("overlap", "must be at least 0 and below 1");
    mel.hop = std::max(1, static_cast<int>(std::lround((1 - overlap) * mel.fft_size)));
  } else if (node.has("hop")) {
    mel.hop = static_cast<int>(node.integer("hop", 1, 1 << 24));
  } else {
    // The largest hop that gives these frames; 1837 for 25 of 1 s at 44.1 kHz.
    const std::int64_t frames = node.integer("frames", 2, 100000, 25);
    mel.hop = static_cast<int>(std::max<std::int64_t>(1, samples / (frames - 1)));
    const std::int64_t made = 1 + samples / mel.hop;
    if (made != frames) {
      node.fail("frames", fmt::format("no hop cuts {} samples into {} frames; the nearest is {}",
                                      samples, frames, made));
    }
    return;
  }
  if (!node.has("frames")) return;
  mel.resized_frames = static_cast<int>(node.integer("frames", 1, 100000));
  const std::int64_t made = 1 + samples / mel.hop;
  if (mel.resized_frames > made) {
    node.fail("frames", fmt::format("there are {} frames at a hop of {} samples: no more can be "
                                    "made of them",
                                    made, mel.hop));
  }
}

void read_bands(ConfigNode& node, synth::signal::MelOptions& mel) {
  mel.bands = static_cast<int>(node.integer("bands", 1, 1024, 64));
  if (!node.has("computed_bands")) return;
  mel.resized_bands = mel.bands;
  mel.bands = static_cast<int>(node.integer("computed_bands", 1, 1024));
  if (mel.bands < mel.resized_bands) {
    node.fail("computed_bands", fmt::format("must be at least `bands`, {}", mel.resized_bands));
  }
}

synth::signal::MelOptions read_mel(ConfigNode node, const scene::AudioConfig& audio) {
  synth::signal::MelOptions mel;
  mel.sample_rate = audio.sample_rate;
  read_bands(node, mel);
  mel.fft_size = static_cast<int>(node.integer("fft_size", 16, 1 << 20, 2048));
  if (mel.fft_size % 2 != 0) node.fail("fft_size", "must be even");
  read_frames(node, static_cast<std::int64_t>(audio.samples()), mel);
  mel.min_frequency = node.quantity("min_frequency", Dimension::frequency, 0);
  mel.max_frequency = node.quantity("max_frequency", Dimension::frequency, audio.sample_rate / 2);
  if (!(mel.min_frequency >= 0 && mel.max_frequency > mel.min_frequency &&
        mel.max_frequency <= audio.sample_rate / 2)) {
    node.fail("max_frequency", "must be above min_frequency and at most half the sample rate");
  }
  if (const int empty = synth::signal::empty_mel_bands(mel); empty > 0) {
    node.fail(mel.resized_bands > 0 ? "computed_bands" : "bands",
              fmt::format("{} of {} bands hold no bin of an FFT of {} (`fft_size`), and would be "
                          "silent whatever sounds",
                          empty, mel.bands, mel.fft_size),
              synth::signal::resolved_mel_bands(mel));
  }
  return mel;
}

render::VoxelOptions read_voxels(ConfigNode node) {
  render::VoxelOptions voxels;
  voxels.resolution = static_cast<int>(node.integer("resolution", 1, 512, 30));
  voxels.fill =
      render::parse_voxel_fill(node.choice("fill", {"surface", "outer", "solid"}, "outer"));
  voxels.pitch = node.not_negative("cell_size", Dimension::length, 0);
  voxels.turns = static_cast<int>(node.integer("turns", 1, render::max_turns, 1));
  return voxels;
}

/// Of `views`: so many in even steps about the vertical from the camera's own azimuth on, or a list
/// of places, where those of the camera are what is not given.
std::vector<render::Camera> read_views(ConfigNode& node, const render::Camera& camera) {
  std::vector<render::Camera> cameras;
  if (node.is_list("views")) {
    for (ConfigNode& view : node.children("views")) {
      cameras.push_back(camera);
      cameras.back().azimuth = view.quantity("azimuth", Dimension::angle, camera.azimuth);
      cameras.back().elevation = view.quantity("elevation", Dimension::angle, camera.elevation);
    }
    if (cameras.empty()) node.fail("views", "there is none", "leave it out for one view");
    return cameras;
  }
  constexpr std::int64_t max_views = 100;
  const auto count = static_cast<std::size_t>(node.integer("views", 1, max_views, 1));
  for (std::size_t v = 0; v < count; ++v) {
    cameras.push_back(camera);
    cameras.back().azimuth +=
        2 * std::numbers::pi * static_cast<double>(v) / static_cast<double>(count);
  }
  return cameras;
}

std::vector<render::Camera> read_cameras(ConfigNode node) {
  render::Camera camera;
  scene::read_picture(node, camera.width, camera.height, camera.field_of_view);
  camera.azimuth = node.quantity("azimuth", Dimension::angle, 0.6);
  camera.elevation = node.quantity("elevation", Dimension::angle, 0.45);
  camera.distance = node.not_negative("distance", Dimension::length, 0);
  return read_views(node, camera);
}

SplitConfig read_split(ConfigNode node) {
  SplitConfig split;
  split.validation = node.quantity("validation", Dimension::none, 0.1);
  split.test = node.quantity("test", Dimension::none, 0.1);
  if (!(split.validation >= 0 && split.test >= 0 && split.validation + split.test <= 1)) {
    node.fail("test", "validation and test are fractions of the whole and add up to at most 1");
  }
  return split;
}

/// Materials and sizes that a shape is struck in: the maximum over the objects.
std::size_t variants_of_a_shape(const BuildConfig& config) {
  const auto chosen = [](Which which, std::size_t count) {
    return which == Which::all ? std::max<std::size_t>(1, count) : 1;
  };
  std::size_t variants = 1;
  for (const ObjectSource& source : config.objects) {
    const std::size_t sizes = source.tune.empty()
                                  ? source.sizes.size() + (source.drawn_size ? 1 : 0)
                                  : source.tune.size();
    variants = std::max(variants,
                        sounding_materials(config, source) * chosen(config.sounding.sizes, sizes));
  }
  return variants;
}

/// Parts that manifests name are parts of the split.
void check_given_parts(ConfigNode& root, const BuildConfig& config) {
  const std::vector<std::string> names = config.split.names();
  for (const ObjectSource& source : config.objects) {
    if (!source.row || source.row->part.empty()) continue;
    if (std::find(names.begin(), names.end(), source.row->part) != names.end()) continue;
    root.child("split").fail(source.row->part, "is 0, and yet a manifest has rows of this part",
                             source.row->place);
  }
}

/// Rows of manifests fail by themselves: the others are built.
void tell_missing_files(BuildConfig& config) {
  for (const ObjectSource& source : config.objects) {
    std::error_code error;
    if (!source.row || std::filesystem::is_regular_file(source.object.pattern, error)) continue;
    config.warnings.push_back(fmt::format("{}: {} is not there: its object will fail",
                                          source.row->place, source.object.pattern));
  }
}

/// The line that names the materials: those of all objects, or the first object's own.
std::string materials_place(ConfigNode& root) {
  if (root.has("materials")) return fmt::format("materials: ({})", root.where("materials"));
  for (const ConfigNode& object : root.children("objects")) {
    if (!object.has("materials")) continue;
    return fmt::format("{}.materials: ({})", object.path(), object.where("materials"));
  }
  return "";
}

/// Told when the configuration is read: the band and the materials are known, no object need be.
void tell_negative_damping(ConfigNode& root, BuildConfig& config) {
  for (scene::EffectDecision& decision : config.scene.effects) {
    if (!decision.enabled || decision.effect->name != std::string_view("damping")) continue;
    const std::string choice = root.choice("negative_damping", {"error", "clamp", "drop"}, "error");
    const std::string told = negative_damping(config.scene.materials, config.band, choice);
    if (told.empty()) continue;
    decision.reason += "; " + told;
    config.warnings.push_back("damping is " + told);
  }
}

std::vector<scene::motion::CastObject> cast_objects(const BuildConfig& config) {
  std::vector<scene::motion::CastObject> objects;
  for (const ObjectSource& source : config.objects) {
    objects.push_back({source.object.name, source.object.materials, source.sizes});
  }
  return objects;
}

/// Every pitch that an object is tuned to is that of a mode which the build has.
void check_tuning(ConfigNode& root, const BuildConfig& config) {
  const solvers::modes::Band& band = config.band;
  for (const ObjectSource& source : config.objects) {
    const std::string place = fmt::format("objects[{}]", source.entry);
    for (const double pitch : source.tune) {
      if (pitch >= band.min_frequency && pitch <= band.max_frequency) continue;
      root.fail("objects",
                fmt::format("{}.tune: {:.6g} Hz lies outside the band of {:.6g} to {:.6g} Hz",
                            place, pitch, band.min_frequency, band.max_frequency),
                "change modes.min_frequency or modes.max_frequency");
    }
    if (!source.tune.empty() && source.tune_mode > band.max_modes) {
      root.fail("objects",
                fmt::format("{}.tune_mode: mode {} is none of the {} that are asked for", place,
                            source.tune_mode, band.max_modes),
                "modes count from 1, the lowest; modes.max_modes bounds them");
    }
  }
}

/// Nothing is solved that no simulation needs, and objects that move radiate by equivalent sources.
void check_cast(ConfigNode& root, const BuildConfig& config) {
  const std::vector<scene::motion::CastBody>& bodies = config.motion->bodies;
  for (std::size_t i = 0; i < config.objects.size(); ++i) {
    const std::string& name = config.objects[i].object.name;
    if (std::any_of(bodies.begin(), bodies.end(),
                    [&](const scene::motion::CastBody& body) { return body.object == name; })) {
      continue;
    }
    root.fail("objects", fmt::format("objects[{}] (\"{}\") plays no part in the motion", i, name),
              "name it under motion.bodies, or remove it");
  }
  for (const ObjectSource& source : config.objects) {
    if (source.drawn_size) {
      root.fail(
          "objects",
          fmt::format("\"{}\" has a drawn size, which bodies in motion lack", source.object.name),
          "give it `sizes`, and the body one of them");
    }
    if (!source.tune.empty()) {
      root.fail(
          "objects",
          fmt::format("\"{}\" is tuned, and bodies in motion have given sizes", source.object.name),
          "`carillon modes --tune` tells the size of a pitch: give it as `sizes`");
    }
  }
  if (root.has("variants")) {
    root.fail("variants", "does not go with `motion`", "bodies have their material and size there");
  }
  ConfigNode radiation = root.child("radiation");
  const std::string model = radiation.text("model", "equivalent_sources");
  if (config.scene.runs("radiation") && model != "equivalent_sources") {
    radiation.fail("model", fmt::format("{} has no answer for objects that turn", model),
                   "with `motion` write equivalent_sources, or off");
  }
}

}  // namespace

std::size_t sounding_materials(const BuildConfig& config, const ObjectSource& source) {
  const std::vector<std::string>& names = source.object.materials;
  if (!source.object.groups.empty() || config.sounding.materials != Which::all) return 1;
  const auto wanted = static_cast<std::size_t>(config.sounding.materials_per_group);
  if (wanted == 0) return std::max<std::size_t>(1, names.size());
  std::map<std::string, std::size_t> by_group;
  for (const std::string& name : names)
    ++by_group[scene::object_material(source.object, name, config.own_materials).group];
  std::size_t count = 0;
  for (const auto& [group, members] : by_group) count += std::min(wanted, members);
  return count;
}

std::set<std::string> named_labels(const BuildConfig& config) {
  std::set<std::string> names;
  for (const ObjectSource& source : config.objects) {
    if (!source.row) continue;
    for (const auto& [name, label] : source.row->labels) names.insert(name);
  }
  return names;
}

std::vector<synth::material::Material> named_materials(const BuildConfig& config) {
  std::map<std::string, synth::material::Material> by_name;
  for (const ObjectSource& source : config.objects) {
    std::vector<std::string> names = source.object.materials;
    for (const auto& [group, name] : source.object.groups) names.push_back(name);
    for (const std::string& name : names) {
      if (by_name.contains(name)) continue;
      by_name[name] = synth::material::parse_material(name, config.own_materials);
    }
  }
  std::vector<synth::material::Material> materials;
  for (auto& [name, material] : by_name) materials.push_back(std::move(material));
  return materials;
}

std::vector<std::string> SplitConfig::names() const {
  std::vector<std::string> names = {"train"};
  if (validation > 0) names.push_back("validation");
  if (test > 0) names.push_back("test");
  return names;
}

BuildConfig read_build_config(const std::string& text, const std::string& file_name,
                              const std::vector<std::string>& overrides,
                              std::span<const scene::Effect> registry, bool with_files) {
  ConfigNode root = ConfigNode::parse(text, file_name, overrides);
  // They say which builds there are and what is made of them, not what one of them is.
  root.leave_alone({"sweep", "train", "search", "evaluate"});
  BuildConfig config;
  config.name = core::folder_name(root, file_name);
  if (root.has("dataset")) config.about = read_about(root.child("dataset"));
  config.seed = static_cast<std::uint64_t>(
      root.integer("seed", 0, std::numeric_limits<std::int64_t>::max(), 0));
  if (root.has("materials_file")) {
    config.materials_file = path_beside(file_name, root.text("materials_file"));
    at_key(root, "materials_file",
           [&] { config.own_materials = synth::material::read_materials(config.materials_file); });
  }
  const std::vector<std::string> materials = root.texts("materials", std::vector<std::string>{});
  std::size_t entry = 0;
  for (ConfigNode& node : root.children("objects")) {
    for (ObjectSource& source : read_objects(node, materials, config.own_materials, file_name)) {
      source.entry = entry;
      config.objects.push_back(std::move(source));
    }
    ++entry;
  }
  if (config.objects.empty()) {
    root.fail("objects", "the configuration has no objects",
              "name some, as in objects: [{shape: bar, materials: [steel]}]");
  }

  if (!root.has("motion")) config.sounding = read_variant_choice(root.child("variants"));
  if (root.has("material_spread"))
    config.spread = read_material_spread(root.child("material_spread"));
  config.split = read_split(root.child("split"));
  check_given_parts(root, config);
  if (with_files) tell_missing_files(config);
  config.scene = scene::read_scene(root, file_name, registry,
                                   {.materials = named_materials(config),
                                    .materials_place = materials_place(root),
                                    .parts = config.split.parts(),
                                    .variants = variants_of_a_shape(config),
                                    .with_files = with_files});
  scene::read_modes(root.child("modes"), config.scene.audio.sample_rate, config);
  check_tuning(root, config);
  if (root.has("motion")) {
    std::shared_ptr<const scene::SupportsConfig> supports;
    if (root.has("supports")) {
      core::ConfigNode node = root.child("supports");
      supports = std::make_shared<const scene::SupportsConfig>(scene::read_supports(node, true));
    }
    config.motion = scene::motion::read_motion(
        root.child("motion"), file_name, cast_objects(config), config.own_materials, supports);
    check_cast(root, config);
    if (!config.scene.runs("motion")) {
      root.child("effects").fail("motion", "cannot be off where there is `motion:`",
                                 "remove `motion:`, or the switch");
    }
  }
  tell_negative_damping(root, config);
  scene::read_solver(root.child("solver"), config);
  config.limits = read_limits(root.child("limits"));
  config.ranks = read_ranks(root.child("ranks"));
  if (root.has("mel")) config.mel = read_mel(root.child("mel"), config.scene.audio);
  if (root.has("voxels")) config.voxels = read_voxels(root.child("voxels"));
  if (root.has("camera")) config.cameras = read_cameras(root.child("camera"));
  if (!config.scene.runs("mel")) config.mel.reset();
  if (!config.scene.runs("voxels")) config.voxels.reset();
  if (!config.scene.runs("frames")) config.cameras.clear();
  price_views(config);
  ConfigNode files = root.child("files");
  config.wav = files.flag("wav", false);
  config.png = files.flag("png", false);
  root.finish();
  config.resolved = without_machine(root.resolved());
  return config;
}

}  // namespace carillon::dataset::configuration
