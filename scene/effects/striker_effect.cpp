#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "core/random.hpp"
#include "core/units.hpp"
#include "scene/effects/detail/list.hpp"
#include "scene/scene.hpp"
#include "synth/contact/hertz_pulse.hpp"
#include "synth/contact/noise_burst.hpp"
#include "synth/contact/striker.hpp"

namespace carillon::scene {

namespace {

constexpr const char* burst_name = "noise_burst";
constexpr const char* own_name = "own";

/// What `striker:` asks for.
struct Strikers {
  std::vector<std::string> kinds;
  std::vector<synth::contact::Striker> elastic;  ///< one per kind; unused for the burst
  core::Range speed{0.3, 2};                     ///< [m/s]
  bool held = false;
  bool curved = false;
  bool hertz = false;  ///< Hertz's own pulse; else the raised cosine
  core::Range hardness{0.9, 0.9};
  core::Range size{0.1, 0.1};
};

/// The striker of a kind, with the values that the configuration gives in its place.
synth::contact::Striker read_elastic(core::ConfigNode& node, const std::string& kind,
                                     bool may_change) {
  using core::Dimension;
  synth::contact::Striker striker;
  const bool own = kind == own_name;
  if (!own) striker = synth::contact::preset_striker(kind);
  if (!own && !may_change) return striker;
  const auto value = [&](const char* key, Dimension dimension, double preset) {
    if (own) return node.quantity(key, dimension);
    return node.quantity(key, dimension, preset);
  };
  striker.name = kind;
  striker.radius = value("radius", Dimension::length, striker.radius);
  striker.youngs_modulus = value("youngs_modulus", Dimension::pressure, striker.youngs_modulus);
  striker.poisson_ratio = value("poisson_ratio", Dimension::none, striker.poisson_ratio);
  striker.restitution = value("restitution", Dimension::none, striker.restitution);
  if (node.has("density")) {
    if (node.has("mass")) {
      node.fail("density", "mass and density exclude each other",
                "a ball's mass follows from both "
                "density and radius: keep one");
    }
    striker.mass =
        synth::contact::ball_mass(striker.radius, node.quantity("density", Dimension::density));
  } else {
    const bool ball = striker.density > 0;  // whose mass follows from its radius
    striker.mass =
        value("mass", Dimension::mass,
              ball ? synth::contact::ball_mass(striker.radius, striker.density) : striker.mass);
  }
  core::at_key(node, "", [&] {
    synth::contact::check_striker(striker);
    return 0;
  });
  return striker;
}

void check_range(const core::ConfigNode& node, const char* key, const core::Range& range,
                 double low, double high, const char* rule) {
  if (!(range.low >= low && range.high <= high && range.low <= range.high)) {
    node.fail(key, fmt::format("must {}, not [{}, {}]", rule, range.low, range.high));
  }
}

void check_kind(const core::ConfigNode& node, const std::string& kind) {
  std::vector<std::string> kinds;
  for (const synth::contact::Striker& striker : synth::contact::preset_strikers())
    kinds.push_back(striker.name);
  kinds.insert(kinds.end(), {own_name, burst_name});
  if (std::find(kinds.begin(), kinds.end(), kind) != kinds.end()) return;
  const std::string nearest = core::nearest_name(kind, kinds);
  node.fail("kind", fmt::format("no striker \"{}\"", kind),
            (nearest.empty() ? "" : fmt::format("did you mean \"{}\"? ", nearest)) +
                fmt::format("there are {}", fmt::join(kinds, ", ")));
}

Strikers read_strikers(core::ConfigNode& root) {
  core::ConfigNode node = root.child("striker");
  Strikers strikers;
  strikers.kinds = node.texts("kind");
  if (strikers.kinds.empty()) {
    node.fail("kind", "names no striker",
              "one or more of metal, wood, rubber, finger, own, "
              "noise_burst");
  }
  const bool single = strikers.kinds.size() == 1;
  bool elastic = false;
  bool burst = false;
  for (const std::string& kind : strikers.kinds) {
    check_kind(node, kind);
    if (kind == burst_name) {
      burst = true;
      strikers.elastic.emplace_back();
    } else {
      elastic = true;
      strikers.elastic.push_back(read_elastic(node, kind, single));
    }
  }
  if (elastic) {
    strikers.speed = node.range("speed", core::Dimension::speed, strikers.speed);
    check_range(node, "speed", strikers.speed, 0, std::numeric_limits<double>::max(),
                "be finite and not negative");
    if (strikers.speed.high == 0) {
      node.fail("speed", "is 0: nothing is struck", "give a speed above 0");
    }
    strikers.held = node.flag("held", false);
    strikers.curved = node.choice("curvature", {"flat", "object"}, "flat") == "object";
    strikers.hertz = node.choice("pulse", {"cosine", "hertz"}, "cosine") == "hertz";
  }
  if (burst) {
    strikers.hardness = node.range("hardness", core::Dimension::none, strikers.hardness);
    strikers.size = node.range("burst_size", core::Dimension::none, strikers.size);
    check_range(node, "hardness", strikers.hardness, 0, 1, "lie between 0 and 1");
    check_range(node, "burst_size", strikers.size, 0, 1, "lie between 0 and 1");
  }
  return strikers;
}

/// Uniform in the logarithm, or plainly where the range begins at 0.
double draw_speed(const core::Range& range, core::RandomStream& random) {
  if (range.low > 0 && range.high > range.low) return random.log_uniform(range.low, range.high);
  return random.uniform(range.low, range.high);
}

/// The object as the striker meets it. Faces do not know their region: of several materials the
/// most compliant is met.
synth::contact::StruckBody struck_body(const Sound& sound, const Strikers& strikers) {
  const RingingObject& object = *sound.object;
  synth::contact::StruckBody struck;
  struck.mass = strikers.held ? std::numeric_limits<double>::infinity() : object.modes->mass;
  double largest = -1;
  for (const synth::material::Material& material : *object.materials) {
    const double nu = material.elastic.poisson_ratio;
    const double compliance = (1 - nu * nu) / material.elastic.youngs_modulus;
    if (compliance <= largest) continue;
    largest = compliance;
    struck.youngs_modulus = material.elastic.youngs_modulus;
    struck.poisson_ratio = nu;
  }
  if (strikers.curved) {
    struck.curvature = synth::contact::mean_curvature(object.modes->surface, sound.strike.point);
  }
  return struck;
}

void record(Sound& sound, const std::string& kind, double speed,
            const synth::contact::HertzContact& contact, const synth::contact::NoiseBurst& burst) {
  if (sound.record == nullptr) return;
  sound.record->add("striker", kind);
  sound.record->add("striker_speed", speed);
  sound.record->add("striker_effective_mass", contact.mass);
  sound.record->add("striker_effective_radius", contact.radius);
  sound.record->add("striker_peak_force",
                    std::abs(sound.strike.impulse) * synth::modal::peak_of(sound.strike.force));
  sound.record->add("striker_hardness", burst.hardness);
  sound.record->add("striker_size", burst.size);
}

/// The burst's strength is the strike's drawn impulse, its own integral is random: the strike then
/// carries that integral as its impulse, and the force is of unit impulse. Their product, which is
/// what rings, stays. A negative impulse pulls.
void set_burst(Sound& sound, synth::modal::ContactForce force) {
  const double integral = synth::modal::impulse_of(force);
  for (double& value : force.samples) value /= integral;
  sound.strike.impulse *= integral;
  synth::modal::check(force);  // refuses an integral of 0, which no draw is known to have
  sound.strike.force = std::move(force);
}

void strike(Sound& sound, const Strikers& strikers) {
  core::RandomStream random(sound.seed, sound.id, "striker");
  const std::size_t chosen = random.index(strikers.kinds.size());
  const std::string& kind = strikers.kinds[chosen];
  if (kind == burst_name) {
    synth::contact::NoiseBurst burst;
    burst.hardness = random.uniform(strikers.hardness.low, strikers.hardness.high);
    burst.size = random.uniform(strikers.size.low, strikers.size.high);
    core::RandomStream noise(sound.seed, sound.id, "striker.noise");
    set_burst(sound, synth::contact::noise_burst(burst, sound.sample_rate, noise));
    record(sound, kind, 0, {}, burst);
    return;
  }
  const double speed = draw_speed(strikers.speed, random);
  const synth::contact::HertzContact contact =
      synth::contact::hertz_contact(strikers.elastic[chosen], struck_body(sound, strikers), speed);
  sound.strike.impulse = contact.impulse;
  sound.strike.force = strikers.hertz ? synth::contact::hertz_pulse(contact.duration)
                                      : synth::modal::ContactForce{.duration = contact.duration};
  record(sound, kind, speed, contact, {0, 0});
}

SceneEffect read(core::ConfigNode& root, const Scene& scene) {
  SceneEffect effect;
  if (!root.has("striker")) {
    effect.reason_off = "no striker: impulse and contact time are those of strikes";
    return effect;
  }
  const Strikers strikers = read_strikers(root);
  effect.asked_by = fmt::format("striker: ({})", root.where("striker"));
  const bool burst =
      std::find(strikers.kinds.begin(), strikers.kinds.end(), burst_name) != strikers.kinds.end();
  effect.seconds_per_sound = burst ? 4e-10 * scene.audio.sample_rate : 1e-6;
  effect.start = [strikers](const std::filesystem::path&) {
    EffectParts parts;
    parts.strike = [strikers](Sound& sound) { strike(sound, strikers); };
    return parts;
  };
  return effect;
}

}  // namespace

const Effect striker_effect = {
    .name = "striker",
    .description = "impulse and force of a striker by Hertz's contact, or Hiner's noise burst",
    .key = "striker",
    .stage = "strike",
    .read = read};

}  // namespace carillon::scene
