#include "scene/single_strike.hpp"

#include <cmath>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "scene/chain.hpp"
#include "scene/columns.hpp"

namespace carillon::scene {

Scene read_strike_scene(const std::string& text, const std::string& name,
                        const std::vector<std::string>& overrides,
                        const std::vector<synth::material::Material>& materials,
                        const std::string& place) {
  core::ConfigNode root = core::ConfigNode::parse(text, name, overrides);
  // A build's configuration holds a scene and more, which is not asked for here.
  root.leave_alone({"name", "seed", "materials", "materials_file", "objects", "modes", "solver",
                    "limits", "mel", "voxels", "camera", "files", "split", "variants", "sweep",
                    "train", "search", "evaluate"});
  Scene scene =
      read_scene(root, name, effects(), {.materials = materials, .materials_place = place});
  root.finish();
  if (!scene.strikes.given.empty()) {
    throw core::InputError("strikes.csv gives the strikes of a build",
                           "leave it out of the scene, and give the point struck");
  }
  if (scene.audio.sample_rate != std::floor(scene.audio.sample_rate)) {
    throw core::InputError("sample_rate must be whole, as files of sound store it");
  }
  return scene;
}

StruckSound strike_once(const Scene& scene, const std::string& shape, const SolvedObject& object,
                        const SingleStrike& strike, const std::filesystem::path& cache) {
  if (strike.known.force && (scene.runs("striker") || !scene.runs("contact"))) {
    throw core::InputError(scene.runs("striker")
                               ? "a force is given, and the scene's striker makes another"
                               : "a force over time is given, and effects.contact is off",
                           "leave one of them out");
  }
  StruckSound struck;
  SoundChain chain(scene, cache, struck.trace);
  const RingingObject ringing = chain.prepare(shape, shape, object.modes, object.materials);
  core::Columns record(columns());
  Sound& sound = struck.sound;
  sound.object = &ringing;
  sound.seed = strike.seed;
  sound.record = &record;
  draw_strike(scene.strikes, object.modes.surface,
              synth::modal::SurfaceSampler(object.modes.surface), {.seed = strike.seed},
              strike.known, sound);
  for (std::size_t i = 1; i < strike.repeat; ++i) {
    sound.strikes.push_back(static_cast<double>(i) * strike.interval);
  }
  chain.make(sound);
  struck.struck = synth::modal::frame_at(object.modes.surface, sound.strike.point);
  struck.impulse = sound.strike.impulse * synth::modal::impulse_of(sound.strike.force);
  struck.unit = sound.rings.readout.unit;
  struck.drawn = record.last_row();
  sound.object = nullptr;
  sound.record = nullptr;
  return struck;
}

nlohmann::json to_json(const StruckSound& struck, const Scene& scene) {
  const auto list = [](const Vec3& v) { return std::vector(v.begin(), v.end()); };
  nlohmann::json planned = nlohmann::json::array(), ran = nlohmann::json::object();
  for (const PlannedEffect& effect : plan_effects(scene)) planned.push_back(to_json(effect));
  for (const auto& [name, entry] : struck.trace.effects) {
    ran[name] = {{"calls", entry.calls}, {"seconds", entry.seconds}};
  }
  const Sound& sound = struck.sound;
  return {{"modes", sound.modes},
          {"modes_above_nyquist", sound.modes_above_nyquist},
          {"unit", struck.unit},
          {"sample_rate_hz", scene.audio.sample_rate},
          {"peak", core::peak(sound.audio)},
          {"position_m", list(struck.struck.position)},
          {"normal", list(struck.struck.normal)},
          {"direction", list(sound.strike.direction)},
          {"impulse_ns", struck.impulse},
          {"contact_time_s", sound.strike.force.duration},
          {"scene", planned},
          {"effects", ran},
          {"record", struck.drawn}};
}

}  // namespace carillon::scene
