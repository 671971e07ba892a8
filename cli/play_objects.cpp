#include "cli/play_objects.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <map>

#include "cli/build_options.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/temporary_folder.hpp"
#include "dataset/run/build.hpp"
#include "dataset/samples/shape_modes.hpp"
#include "scene/single_strike.hpp"

namespace carillon::cli {

namespace {

namespace live = scene::live;

/// So many places on a single object for keys: four octaves of a keyboard.
constexpr std::size_t spread_places = 49;

void check_count(std::size_t count, std::size_t most) {
  if (count <= most) return;
  throw core::InputError(fmt::format("{} objects are more than {}", count, most),
                         "raise --max-objects, or name fewer");
}

std::size_t places_for(std::size_t objects) {
  return objects == 1 ? spread_places : 0;
}

PlayedObjects of_configuration(const PlayedWhat& what, const std::vector<std::string>& keys,
                               const Context& context) {
  if (what.what.size() > 1 || !what.scene.empty() || !what.object.material.empty()) {
    throw core::InputError("a configuration is played by itself",
                           "it has its own objects, materials and scene: leave the others out");
  }
  dataset::run::BuildOptions options;
  options.config = what.what.front();
  options.overrides = keys;
  dataset::run::LoadedBuild build =
      dataset::run::load_build(with_common(options, context), context.world);
  std::size_t count = 0;
  for (const dataset::plan::Shape& shape : build.plan.shapes) {
    for (const auto& variant : shape.variants) count += variant.sounds ? 1 : 0;
  }
  check_count(count, what.max_objects);
  build.config.cameras.clear();
  build.config.voxels.reset();
  build.config.mel.reset();
  build.config.png = false;

  PlayedObjects played;
  played.scene = build.config.scene;
  if (build.config.motion) {  // which strikes its objects itself
    played.scene.strikes = scene::read_strike_scene("{}", "play", {}, played.scene.materials,
                                                    played.scene.materials_place)
                               .strikes;
  }
  const core::TemporaryFolder folder;
  const dataset::samples::BuildFolders folders{folder.path(), context.cache};
  const live::LiveStage stage(played.scene, live::contacts_of(build.config.resolved), what.seed,
                              context.cache);
  core::Trace trace;
  for (const dataset::plan::Shape& shape : build.plan.shapes) {
    const dataset::samples::ModesTaskResult result =
        dataset::samples::run_modes_task(build.config, shape, folders, context.world, trace);
    for (const std::string& warning : result.warnings) spdlog::warn("{}: {}", shape.id, warning);
    const dataset::samples::ShapeModes modes(build.config, shape, folders);
    for (std::size_t v = 0; v < shape.variants.size(); ++v) {
      if (!shape.variants[v].sounds) continue;
      const std::string name = dataset::plan::object_name(shape.id, shape.variants[v]);
      played.objects.push_back(stage.make(name, name,
                                          std::make_shared<solvers::modes::Modes>(modes.of(v)),
                                          modes.materials(v), places_for(count)));
    }
  }
  return played;
}

/// What an object is called: a file's stem, or the shape as it was typed.
std::string short_name(const std::string& object) {
  const std::filesystem::path path(object);
  return path.has_extension() && std::filesystem::exists(path) ? path.stem().string() : object;
}

PlayedObjects of_objects(const PlayedWhat& what, const std::vector<std::string>& keys,
                         const Context& context) {
  check_count(what.what.size(), what.max_objects);
  std::vector<ObjectOptions> options;
  std::vector<synth::material::Material> materials;
  for (const std::string& name : what.what) {
    ObjectOptions object = what.object;
    object.mesh = name;
    name_material(object, context);
    for (auto& material : scene::listed(region_materials(object))) materials.push_back(material);
    options.push_back(std::move(object));
  }
  const bool bare = what.scene.empty();
  const std::string text = bare ? "{}" : core::read_text_file(what.scene);
  const std::string file = bare ? "play" : what.scene;
  PlayedObjects played;
  played.scene = scene::read_strike_scene(text, file, keys, materials, "--material");
  std::string contacts;
  if (played.scene.runs("supports")) {
    core::ConfigNode root = core::ConfigNode::parse(text, file, keys);
    scene::read_scene(root, file, scene::effects(), {.materials = materials});
    contacts = live::contacts_of(root.resolved());
  }
  const live::LiveStage stage(played.scene, contacts, what.seed, context.cache);
  std::map<std::string, live::LiveObject> made;
  std::map<std::string, int> times;
  for (ObjectOptions& object : options) {
    if (!object.max_frequency) {
      object.max_frequency =
          fmt::format("{} Hz", std::min(20000.0, played.scene.audio.sample_rate / 2));
    }
    auto found = made.find(object.mesh);
    if (found == made.end()) {
      scene::SolvedObject solved = solve_object(object, context);
      found =
          made.emplace(object.mesh,
                       stage.make(short_name(object.mesh), object.mesh,
                                  std::make_shared<solvers::modes::Modes>(std::move(solved.modes)),
                                  solved.materials, places_for(options.size())))
              .first;
    }
    live::LiveObject copy = found->second;
    if (const int time = ++times[copy.name]; time > 1) copy.name += fmt::format("-{}", time);
    played.objects.push_back(std::move(copy));
  }
  return played;
}

bool is_configuration(const std::string& name) {
  return name.ends_with(".yaml") || name.ends_with(".yml");
}

}  // namespace

PlayedObjects played_objects(PlayedWhat what, std::vector<std::string> keys,
                             const Context& context) {
  keys.insert(keys.end(), what.overrides.begin(), what.overrides.end());
  for (const std::string& name : what.what) {
    if (is_configuration(name)) return of_configuration(what, keys, context);
  }
  return of_objects(what, keys, context);
}

}  // namespace carillon::cli
