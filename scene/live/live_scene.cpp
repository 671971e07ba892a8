#include "scene/live/live_scene.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <string_view>
#include <utility>

#include "core/error.hpp"
#include "scene/chain.hpp"
#include "scene/columns.hpp"
#include "scene/single_strike.hpp"
#include "scene/strikes.hpp"

namespace carillon::scene::live {

namespace {

std::string text_of(const YAML::Node& node) {
  YAML::Emitter emitter;
  emitter << node;
  return emitter.c_str();
}

/// What a sound needs to be struck at a place that the seed draws.
struct Drawn {
  core::Trace trace;
  SoundChain chain;
  RingingObject object;
  Sound sound;

  Drawn(const Scene& scene, const std::filesystem::path& cache, const std::string& shape,
        const solvers::modes::Modes& modes, const std::vector<synth::material::Material>& materials,
        std::uint64_t seed)
      : chain(scene, cache, trace), object(chain.prepare(shape, shape, modes, materials)) {
    sound.object = &object;
    sound.seed = seed;
    draw_strike(scene.strikes, modes.surface, synth::modal::SurfaceSampler(modes.surface),
                {.seed = seed}, {}, sound);
  }
};

}  // namespace

std::vector<LiveEffect> live_effects(const Scene& scene) {
  const auto how = [](const Effect& effect) -> std::pair<bool, const char*> {
    const std::string name = effect.name;
    if (name == "damping") return {true, "decay rates of each object"};
    if (name == "radiation") return {true, "pressure at the listeners"};
    if (name == "contact") return {true, "each strike's own contact time"};
    if (name == "supports")
      return {true, "modes stay uncoupled; springs stay, dashpots can be put on and off"};
    if (name == "striker") return {false, "strikes give impulse and contact time themselves"};
    if (std::string_view(effect.stage) == "motion") return {false, "objects stay where they are"};
    return {false, "it works on whole clips"};
  };
  std::vector<LiveEffect> effects;
  for (const EffectDecision& decision : scene.effects) {
    if (!decision.enabled || std::string_view(decision.effect->stage) == "view") continue;
    const auto [heard, why] = how(*decision.effect);
    effects.push_back({decision.effect->name, heard, why});
  }
  return effects;
}

std::string contacts_of(const std::string& resolved) {
  const YAML::Node root = YAML::Load(resolved);
  const YAML::Node contacts = root["supports"] ? root["supports"]["contacts"] : YAML::Node();
  return contacts && contacts.IsSequence() ? text_of(contacts) : "";
}

LiveStage::LiveStage(const Scene& scene, const std::string& supports, std::uint64_t seed,
                     std::filesystem::path cache)
    : scene_(scene), seed_(seed), cache_(std::move(cache)) {
  if (!scene.runs("supports") || supports.empty()) return;
  for (YAML::Node contact : YAML::Load(supports)) {
    contact["probability"] = 1;
    // Springs are in the modes that the whole scene leaves; dashpots come and go.
    contact["stiffness"] = contact["bed_stiffness"] = 0;
    YAML::Node alone;
    alone["supports"]["coupling"] = "diagonal";
    alone["supports"]["contacts"].push_back(contact);
    alone["strikes"]["impulse"] = default_impulse;
    alone["strikes"]["contact_time"] = default_contact_time;
    holds_.push_back({contact["kind"] ? contact["kind"].as<std::string>() : "support",
                      contact["coefficient"].as<double>(), contact["resistance"].as<double>(),
                      read_strike_scene(text_of(alone), "supports", {}, scene.materials,
                                        scene.materials_place)});
  }
}

LiveObject LiveStage::make(const std::string& name, const std::string& shape,
                           std::shared_ptr<const solvers::modes::Modes> modes,
                           const std::vector<synth::material::Material>& materials,
                           std::size_t places) const {
  LiveObject live;
  live.name = name;
  live.modes = std::move(modes);
  const Drawn drawn(scene_, cache_, shape, *live.modes, materials, seed_);
  if (drawn.object.held) live.modes = drawn.object.held;
  live.decay_rates = drawn.object.decay_rates;
  live.place = drawn.sound.strike.point;
  live.readout = drawn.object.pressure.delays.empty()
                     ? synth::modal::point_velocity(*live.modes, live.place)
                     : drawn.object.pressure;
  for (std::size_t i = 0; i < holds_.size(); ++i) {
    Drawn held(holds_[i].scene, {}, shape, *live.modes, materials, seed_);
    core::Columns record(columns());
    held.sound.record = &record;
    held.chain.ring(held.sound);
    LiveSupport support;
    support.name = holds_[i].kind;
    for (const double force : record.last_row()["support_force"].get<std::vector<double>>()) {
      support.damping += holds_[i].coefficient * force + holds_[i].resistance;
    }
    if (support.damping == 0) support.damping = 1;
    support.unit = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(live.modes->size()));
    for (std::size_t m = 0; m < live.modes->size(); ++m) {
      support.unit[static_cast<Eigen::Index>(m)] =
          2 * (held.sound.rings.decay_rates[m] - held.object.decay_rates[m]) / support.damping;
    }
    live.supports.push_back(std::move(support));
  }
  if (places > 0) {
    core::RandomStream random(seed_, 0, "live.places");
    live.places = spread_points(synth::modal::SurfaceSampler(live.modes->surface),
                                live.modes->surface, places, random);
  }
  return live;
}

}  // namespace carillon::scene::live
