#include "eval/accuracy/sound_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "core/json.hpp"
#include "core/numbers.hpp"
#include "eval/accuracy/detail/study_object.hpp"
#include "eval/perception/spectral_distance.hpp"
#include "scene/chain.hpp"
#include "scene/strikes.hpp"

namespace carillon::eval::accuracy {

using nlohmann::ordered_json;

namespace {

std::vector<int> ascending_numbers(core::ConfigNode& node, const std::string& key, int minimum) {
  const std::vector<double> values =
      node.quantities(key, core::Dimension::none, 0, std::vector<double>{});
  std::vector<int> numbers;
  for (const double value : values) {
    const bool grows = numbers.empty() || value > numbers.back();
    if (value != std::floor(value) || value < minimum || value > 1e6 || !grows) {
      node.fail(key, fmt::format("must be whole numbers from {} up, each above the last", minimum));
    }
    numbers.push_back(static_cast<int>(value));
  }
  return numbers;
}

scene::Scene read_study_scene(core::ConfigNode sound, const std::string& file_name,
                              const scene::RegionMaterials& materials) {
  core::ConfigNode node = sound.child("scene");
  return scene::read_scene(
      node, file_name, scene::effects(),
      {.materials = scene::listed(materials), .materials_place = "sound.object.materials"});
}

/// One level's sounds, and what each took [s].
struct Sounds {
  std::vector<std::vector<double>> clips;  ///< of the first listener
  std::vector<double> seconds;
};

/// Strikes are those of the same numbers whatever the scene. Each is made twice and timed the
/// second time, as in a build of many: the first fills caches and tables.
Sounds make_sounds(const scene::Scene& scene, int strikes, const scene::RingingObject& object) {
  Sounds made;
  core::Trace trace;
  scene::SoundChain chain(scene, {}, trace);
  const synth::modal::SurfaceSampler sampler(object.modes->surface);
  for (int k = 0; k < 2 * strikes; ++k) {
    scene::Sound sound;
    sound.object = &object;
    sound.id = static_cast<std::uint64_t>(k % strikes);
    scene::draw_strike(scene.strikes, object.modes->surface, sampler,
                       {.place = sound.id, .force = sound.id}, {}, sound);
    const double start = core::thread_cpu_seconds();
    chain.make(sound);
    if (k < strikes) continue;
    made.seconds.push_back(core::thread_cpu_seconds() - start);
    const auto row = sound.row(0);
    made.clips.emplace_back(row.begin(), row.end());
  }
  return made;
}

/// The lowest modes of an object that rings: `count` of them, or fewer where that would part modes
/// of one pitch.
struct FewerModes {
  FewerModes(const scene::RingingObject& all, int count) : object(all) {
    const solvers::modes::Certificate& solved = all.modes->certificate;
    modes = solvers::modes::restrict_to(*all.modes, {.min_frequency = solved.min_frequency,
                                                     .max_frequency = solved.max_frequency,
                                                     .max_modes = count});
    object.modes = &modes;
    object.decay_rates.resize(modes.size());
    for (Eigen::MatrixXd* gains : synth::modal::gains_of(object.pressure)) {
      if (gains->size() > 0)
        *gains = gains->leftCols(static_cast<Eigen::Index>(modes.size())).eval();
    }
  }
  FewerModes(const FewerModes&) = delete;
  FewerModes& operator=(const FewerModes&) = delete;

  solvers::modes::Modes modes;
  scene::RingingObject object;
};

SoundFindings::RefinementLevel level(const std::string& key, int value, const Sounds& made,
                                     const Sounds& full) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < full.clips.size(); ++i) {
    const double peak = core::peak(full.clips[i]);
    if (!(peak > 0)) continue;  // a strike on a node of every mode
    std::vector<double> one = full.clips[i], other = made.clips[i];
    for (double& sample : one) sample /= peak;
    for (double& sample : other) sample /= peak;
    errors.push_back(20 / std::numbers::ln10 *
                     perception::spectral_distance(one, other).log_magnitude);
  }
  return {key, value, errors.size(), core::median(made.seconds), core::median(errors)};
}

}  // namespace

SoundStudy read_sound_study(
    core::ConfigNode node, const std::vector<std::string>& materials, const std::string& file_name,
    const std::function<core::ConfigNode(const std::vector<std::string>&)>& reread) {
  SoundStudy study;
  core::ConfigNode entry = node.child("object");
  const scene::Object object = scene::read_object(entry, materials, {}, file_name);
  study.name = object.name.empty() ? object.pattern : object.name;
  study.object.mesh = only_mesh(entry, object);
  study.object.any_size = object.file.any_size;
  study.material = only_material(entry, object);
  study.object.materials = scene::region_materials(object, study.material);
  study.strikes = static_cast<int>(node.integer("strike_count", 1, 10000, 5));
  study.mode_counts = ascending_numbers(node, "mode_counts", 1);
  study.image_orders = ascending_numbers(node, "image_orders", 0);
  const auto changed_scene = [&](const std::vector<std::string>& changes) {
    return read_study_scene(reread(changes).child("sound"), file_name, study.object.materials);
  };
  // Read once as it stands, so that mistakes in it are named where they are.
  const scene::Scene scene = read_study_scene(node, file_name, study.object.materials);
  // One object serves all levels; these effects know only objects that they have prepared
  // themselves.
  for (const char* effect : {"click", "supports"}) {
    if (scene.runs(effect)) {
      node.fail("scene", fmt::format("levels are heard without the effect \"{}\"", effect),
                fmt::format("add `effects: {{{}: \"off\"}}`", effect));
    }
  }
  study.without_room =
      node.child("scene").has("room")
          ? changed_scene({"sound.scene.effects.room=off", "sound.scene.effects.tail=off",
                           "sound.scene.effects.response=off"})
          : scene;
  study.object.solve.band.max_frequency =
      std::min(20000.0, study.without_room.audio.sample_rate / 2);
  if (study.image_orders.size() == 1) {
    node.fail("image_orders",
              "the last one is what the others are compared with: give two or more");
  }
  if (!study.image_orders.empty() && !scene.runs("room")) {
    node.fail("image_orders", "there are no reflections: `scene:` has no room that is heard");
  }
  for (const int order : study.image_orders) {
    study.of_order.push_back(
        changed_scene({fmt::format("sound.scene.room.image_order={}", order)}));
  }
  return study;
}

ordered_json to_json(const SoundFindings& findings) {
  if (!findings.failure.empty()) return {{"failure", findings.failure}};
  ordered_json levels = ordered_json::array();
  for (const SoundFindings::RefinementLevel& level : findings.levels) {
    levels.push_back({{"key", level.key},
                      {"value", level.value},
                      {"sounds", level.sounds},
                      {"seconds", level.seconds},
                      {"error_db", core::number_or_null(level.error_db)}});
  }
  return {{"object", findings.object},
          {"material", findings.material},
          {"modes", findings.modes},
          {"prepare_s", findings.prepare_s},
          {"levels", levels}};
}

void print(const SoundFindings& findings) {
  if (!findings.failure.empty()) {
    fmt::print("\nsound: {}\n", findings.failure);
    return;
  }
  fmt::print("\nsound of {}, {} modes\n{:<14}{:>8}{:>12}{:>10}\n", findings.object, findings.modes,
             "", "", "s", "dB");
  for (const SoundFindings::RefinementLevel& level : findings.levels) {
    fmt::print("{:<14}{:>8}{:>12.2g}{:>10}\n", level.key, level.value, level.seconds,
               std::isfinite(level.error_db) ? fmt::format("{:.3g}", level.error_db) : "silent");
  }
}

SoundFindings measure_sounds(const SoundStudy& study, MPI_Comm alone,
                             const std::filesystem::path& cache) {
  const scene::SolvedObject solved = scene::solve_object(study.object, alone, cache);
  core::Trace trace;
  scene::SoundChain chain(study.without_room, cache, trace);
  const double before = core::thread_cpu_seconds();
  const scene::RingingObject object =
      chain.prepare(study.name, study.name, solved.modes, solved.materials);
  const double prepared = core::thread_cpu_seconds() - before;
  std::vector<SoundFindings::RefinementLevel> levels;
  const Sounds all_modes = make_sounds(study.without_room, study.strikes, object);
  for (const int count : study.mode_counts) {
    if (static_cast<std::size_t>(count) >= solved.modes.size()) break;
    const FewerModes fewer(object, count);
    levels.push_back(level(
        "modes", count, make_sounds(study.without_room, study.strikes, fewer.object), all_modes));
  }
  levels.push_back(level("modes", static_cast<int>(solved.modes.size()), all_modes, all_modes));
  if (!study.of_order.empty()) {
    const Sounds full = make_sounds(study.of_order.back(), study.strikes, object);
    for (std::size_t i = 0; i + 1 < study.of_order.size(); ++i) {
      levels.push_back(level("image order", study.image_orders[i],
                             make_sounds(study.of_order[i], study.strikes, object), full));
    }
    levels.push_back(level("image order", study.image_orders.back(), full, full));
  }
  return {.object = study.name,
          .material = study.material,
          .modes = solved.modes.size(),
          .prepare_s = prepared,
          .levels = std::move(levels)};
}

}  // namespace carillon::eval::accuracy
