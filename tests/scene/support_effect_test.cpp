// What `supports:` means in a configuration, and what it does to a sound.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/error.hpp"
#include "scene/columns.hpp"
#include "scene/effects/detail/list.hpp"
#include "scene/scene.hpp"
#include "scene/support_config.hpp"
#include "tests/synth/curved_bodies.hpp"

namespace carillon::scene {
namespace {

constexpr double fixed_radius = 0.05;

solvers::modes::Modes ball() {
  std::vector<double> eigenvalues;
  for (int i = 0; i < 12; ++i) eigenvalues.push_back(std::pow(6.28 * (300 + 500 * i), 2));
  auto modes =
      synth::modes_with(synth::curved_sphere(fixed_radius, Vec3(1, 0, 0), 4, 2), eigenvalues,
                        [](int mode, const Vec3& x) -> Vec3 {
                          const Vec3 out = x - Vec3(1, 0, 0);
                          return 40 * std::cos(40 * out.dot(Vec3(1, 0.3 * mode, -0.7))) * out;
                        });
  modes.mass = 0.3;
  return modes;
}

SceneEffect read_effect(const std::string& text) {
  core::ConfigNode root = core::ConfigNode::parse(text, "scene.yaml");
  SceneEffect effect = supports_effect.read(root, Scene{});
  root.finish();
  return effect;
}

struct Held {
  synth::modal::RingDown rings;
  nlohmann::json record;
};

/// One sample of the ball under `supports: {...}`.
Held hold(const std::string& supports, std::uint64_t id = 1, const std::string& material = "") {
  static const solvers::modes::Modes modes = ball();
  static const synth::modal::SurfaceSampler sampler(modes.surface);
  const EffectParts parts = read_effect("supports: {" + supports + "}").start("");
  RingingObject object;
  object.id = "ball/" + material;
  object.shape = "ball";
  object.modes = &modes;
  object.centre = {1, 0, 0};
  object.decay_rates.assign(modes.size(), 3.0);
  parts.object(object);
  core::Columns columns(scene::columns());
  Sound sound;
  sound.object = &object;
  sound.seed = 5;
  sound.id = id;
  sound.record = &columns;
  sound.strike = {sampler.nearest({1, 0, 1}), {0, 0, -1}, 0.01, {}};
  sound.rings = synth::modal::ring_down(modes, object.decay_rates, sound.strike,
                                        synth::modal::point_velocity(modes, sound.strike.point));
  parts.rings(sound);
  return {sound.rings, columns.last_row()};
}

double fastest(const synth::modal::RingDown& rings) {
  return *std::max_element(rings.decay_rates.begin(), rings.decay_rates.end());
}

TEST(SupportsEffect, IsOffInFreeFlight) {
  const SceneEffect effect = read_effect("{}");
  EXPECT_TRUE(effect.asked_by.empty());
  EXPECT_EQ(effect.reason_off, "free flight: no supports:");
}

TEST(SupportsEffect, ContactsAreThereAsOftenAsTheirProbability) {
  const std::string contacts =
      "contacts: [{kind: finger, count: 1, force: 1, probability: 0.3}, "
      "{kind: table, lowest: true, probability: 0.5}]";
  const double weight = 0.3 * 9.80665;
  int fingers = 0, tables = 0;
  constexpr int samples = 400;
  for (std::uint64_t id = 0; id < samples; ++id) {
    const Held held = hold(contacts, id);
    const nlohmann::json& forces = held.record.at("support_force");
    EXPECT_TRUE(forces[0] == 0.0 || forces[0] == 1.0) << forces;
    EXPECT_TRUE(forces[1] == 0.0 || std::abs(forces[1].get<double>() - weight) < 1e-9) << forces;
    fingers += forces[0] != 0.0 ? 1 : 0;
    tables += forces[1] != 0.0 ? 1 : 0;
    if (forces[0] == 0.0 && forces[1] == 0.0) {
      EXPECT_EQ(fastest(held.rings), 3) << "free flight";
      EXPECT_EQ(held.record.at("support_damping"), 0.0);
    } else {
      EXPECT_GT(fastest(held.rings), 3);
    }
  }
  // Within four deviations of a binomial draw.
  EXPECT_NEAR(fingers, 0.3 * samples, 4 * std::sqrt(0.21 * samples));
  EXPECT_NEAR(tables, 0.5 * samples, 4 * std::sqrt(0.25 * samples));
  for (const std::string probability : {"0", "1.5", "-0.1"}) {
    EXPECT_THROW(read_effect("supports: {contacts: [{kind: finger, count: 1, probability: " +
                             probability + "}]}"),
                 core::ConfigError);
  }
}

TEST(SupportsEffect, WithoutContactsCoupledModesAreThoseOfFreeFlight) {
  bool free = false;
  for (std::uint64_t id = 0; id < 20 && !free; ++id) {
    const Held held = hold(
        "coupling: full, contacts: [{kind: finger, count: 1, force: 1, probability: 0.2}]", id);
    free = held.record.at("support_force")[0] == 0.0;
    if (!free) continue;
    for (const double rate : held.rings.decay_rates) EXPECT_NEAR(rate, 3, 1e-12);
  }
  EXPECT_TRUE(free);
}

TEST(SupportsEffect, NamesTheLineThatAsksForIt) {
  const SceneEffect effect =
      read_effect("\nsupports:\n  contacts: [{kind: finger, at: [0, 0, 5 cm]}]\n");
  EXPECT_EQ(effect.asked_by, "supports: (scene.yaml:2)");
  EXPECT_TRUE(effect.reason_off.empty());
  EXPECT_GT(effect.seconds_per_sound, 0);
}

TEST(SupportsEffect, ShortensT60WithTheForce) {
  const auto light = hold("contacts: [{kind: finger, at: [0, 0, 5 cm], force: 0.1 N}]");
  const auto firm = hold("contacts: [{kind: finger, at: [0, 0, 5 cm], force: 10 N}]");
  for (std::size_t i = 0; i < 12; ++i) {
    EXPECT_GE(light.rings.decay_rates[i], 3.0);
    // d gains in proportion to the force.
    EXPECT_NEAR(firm.rings.decay_rates[i] - 3, 100 * (light.rings.decay_rates[i] - 3), 1e-9);
  }
  EXPECT_GT(fastest(light.rings), 3.0);
  EXPECT_NEAR(firm.record.at("support_damping").get<double>(), fastest(firm.rings) - 3, 1e-9);
}

TEST(SupportsEffect, DrawsPlacesAndForcesAnewForEachSampleAndRecordsThem) {
  const std::string text = "contacts: [{kind: finger, count: 2, force: [0.5 N, 4 N]}]";
  const auto first = hold(text, 1), again = hold(text, 1), other = hold(text, 2);
  EXPECT_EQ(first.record, again.record);
  EXPECT_EQ(first.rings.decay_rates, again.rings.decay_rates);
  EXPECT_NE(first.record, other.record);
  const auto forces = first.record.at("support_force").get<std::vector<double>>();
  ASSERT_EQ(forces.size(), 2u);
  EXPECT_NE(forces[0], forces[1]);
  for (const double force : forces) EXPECT_TRUE(force >= 0.5 && force <= 4);
  const auto places = first.record.at("support_position");
  std::vector<double> flat;
  for (const auto& value : places.flatten()) flat.push_back(value.get<double>());
  ASSERT_EQ(flat.size(), 6u);
  for (std::size_t k = 0; k < 6; k += 3) {
    EXPECT_NEAR((Vec3(flat[k], flat[k + 1], flat[k + 2])).norm(), fixed_radius, 1e-3);
  }
}

TEST(SupportsEffect, TakesEachSamplesPlaceFromItsBodysPool) {
  const std::string text = "contacts: [{kind: finger, count: 1, pool: 4, force: [0.5 N, 4 N]}]";
  std::map<int, std::set<nlohmann::json>> seen;
  for (std::uint64_t id = 0; id < 60; ++id) {
    const auto record = hold(text, id, id % 2 == 0 ? "steel" : "glass").record;
    const int index = record.at("support_index").at(0);
    seen[index].insert(
        nlohmann::json::array({record.at("support_force"), record.at("support_position")}));
  }
  // All four of them, each with one place and one force, in both materials.
  ASSERT_EQ(seen.size(), 4u);
  std::set<nlohmann::json> places;
  for (const auto& [index, found] : seen) {
    EXPECT_TRUE(index >= 0 && index < 4);
    EXPECT_EQ(found.size(), 1u);
    places.insert(*found.begin());
    const double force = (*found.begin()).at(0).at(0);
    EXPECT_TRUE(force >= 0.5 && force <= 4);
  }
  EXPECT_EQ(places.size(), 4u);
  // The damping is that of the place: the same index, the same decay.
  const auto at = [&](std::uint64_t id) { return hold(text, id); };
  std::map<int, std::vector<double>> rates;
  for (std::uint64_t id = 0; id < 20; ++id) {
    const Held held = at(id);
    const int index = held.record.at("support_index").at(0);
    if (!rates.contains(index)) rates[index] = held.rings.decay_rates;
    EXPECT_EQ(held.rings.decay_rates, rates[index]);
  }
}

TEST(SupportsEffect, TakesDifferentPlacesOfAPoolAtATime) {
  const std::string pool = "{kind: finger, count: 3, pool: 3}";
  const std::string other = "{kind: table, count: 1}";
  for (std::uint64_t id = 0; id < 8; ++id) {
    const auto record = hold("contacts: [" + other + ", " + pool + "]", id).record;
    auto indices = record.at("support_index").get<std::vector<int>>();
    ASSERT_EQ(indices.size(), 4u);
    EXPECT_EQ(indices.front(), -1);
    std::sort(indices.begin(), indices.end());
    EXPECT_EQ(indices, (std::vector{-1, 0, 1, 2}));
    EXPECT_NEAR(record.at("support_force").at(0).get<double>(), 0.3 * 9.80665, 1e-12);
  }
}

TEST(SupportsEffect, OfAPoolLeavesWhatIsDrawnForEachSampleAsItWas) {
  const std::string drawn = "{kind: finger, count: 2, force: [0.5 N, 4 N]}";
  const auto alone = hold("contacts: [" + drawn + "]").record;
  const auto beside = hold("contacts: [" + drawn + ", {kind: foam, count: 1, pool: 2}]").record;
  EXPECT_FALSE(alone.contains("support_index"));
  for (int k = 0; k < 2; ++k) {
    EXPECT_EQ(alone.at("support_force").at(k), beside.at("support_force").at(k));
    EXPECT_EQ(alone.at("support_position").at(k), beside.at("support_position").at(k));
  }
}

TEST(SupportsEffect, RefusesAPoolSmallerThanWhatIsTakenOfIt) {
  try {
    read_effect("supports:\n  contacts: [{kind: finger, count: 3, pool: 2}]\n");
    FAIL();
  } catch (const core::ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("scene.yaml:2"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("pool"), std::string::npos) << error.what();
  }
  // Fixed places have none.
  EXPECT_THROW(read_effect("supports: {contacts: [{kind: finger, at: [0, 0, 1], pool: 2}]}"),
               core::ConfigError);
}

TEST(SupportsEffect, SharesTheWeightAmongWhatBearsIt) {
  const auto record =
      hold(
          "contacts: [{kind: table, lowest: true}, {kind: string, along: [-5 cm, 0, "
          "0, 5 cm, 0, 0], count: 5}, {kind: finger, at: [0, 0, 5 cm], force: 2 N}]")
          .record;
  const auto forces = record.at("support_force").get<std::vector<double>>();
  ASSERT_EQ(forces.size(), 3u);
  EXPECT_NEAR(forces[0], 0.3 * 9.80665 / 2, 1e-12);
  EXPECT_NEAR(forces[1], forces[0], 1e-12);
  EXPECT_NEAR(forces[2], 2, 1e-12);
}

TEST(SupportsEffect, FullCouplingAgreesWithTheDiagonalForALightTouch) {
  const std::string touch =
      "contacts: [{kind: finger, at: [0, 0, 5 cm], radius: 5 mm, force: 1 mN}]";
  const auto diagonal = hold(touch);
  const auto full = hold("coupling: full, " + touch);
  for (std::size_t i = 0; i < 12; ++i) {
    EXPECT_NEAR(full.rings.decay_rates[i] / diagonal.rings.decay_rates[i], 1, 1e-5);
  }
  EXPECT_EQ(full.record.at("support_coupled").get<int>(), 1);
  EXPECT_EQ(full.record.at("support_modes_compared").get<int>(), 12);
  EXPECT_LT(full.record.at("support_decay_error").get<double>(), 1e-5);
  EXPECT_EQ(full.record.at("support_modes").get<int>(), 12);
  EXPECT_FALSE(diagonal.record.contains("support_decay_error"));
  const double estimate = diagonal.record.at("support_decay_error_estimate").get<double>();
  EXPECT_TRUE(estimate > 0 && estimate < 1e-4) << estimate;
  const auto firm =
      hold("coupling: full, contacts: [{kind: finger, at: [0, 0, 5 cm], force: 5 kN}]");
  EXPECT_GT(firm.record.at("support_decay_error").get<double>(), 1e-3);
}

TEST(SupportsEffect, RefusesAPlaceFarFromTheObject) {
  EXPECT_THROW(hold("contacts: [{kind: finger, at: [0, 0, 5]}]"), core::InputError);
  EXPECT_THROW(hold("contacts: [{kind: string, along: [-5, 0, 0, 5, 0, 0]}]"), core::InputError);
}

TEST(SupportsEffect, PlansForTheCubeOfTheModesWhenCoupled) {
  const auto seconds = [](const char* text, int modes) {
    return read_effect(text).seconds_by_modes(modes);
  };
  const char* full = "supports: {coupling: full, contacts: [{kind: finger, count: 1}]}";
  EXPECT_NEAR(seconds(full, 300) / seconds(full, 100), 27, 1e-9);
}

// Of a mass on a spring and a dashpot: omega^2 = k / m, d = r / 2 m; the modes far above feel
// little.
TEST(SupportsEffect, SpringsAndDashpotsHoldTheBodyAsAWhole) {
  solvers::modes::Modes modes = ball();
  modes.certificate.min_frequency = 20;
  RingingObject object;
  object.id = object.shape = "ball";
  object.modes = &modes;
  object.centre = {1, 0, 0};
  object.decay_rates.assign(modes.size(), 0.0);
  object.moves = true;
  core::ConfigNode node = core::ConfigNode::parse(
      "contacts: [{stiffness: 100 kN/m, resistance: 6 N s/m, shear: 0, at: [0, 0, -5 cm]}]",
      "s.yaml");
  const SupportsConfig config = read_supports(node, true);
  object.held_by = &config;
  const EffectParts parts = read_effect("motion: {bodies: [{fixed: true}]}").start("");
  EXPECT_FALSE(parts.rings);
  parts.object(object);
  ASSERT_NE(object.modes, &modes);
  EXPECT_NEAR(object.modes->eigenvalues[0] / (1e5 / modes.mass), 1, 0.05);
  EXPECT_NEAR(object.decay_rates[0], 6 / modes.mass / 2, 0.5);
  EXPECT_LT(object.modes->eigenvalues[0], 1e5 / modes.mass);  // the ball gives way too

  // What is free in such a scene is left as it is.
  RingingObject free = object;
  free.held_by = nullptr;
  free.held = nullptr;
  free.modes = &modes;
  free.decay_rates.assign(modes.size(), 0.0);
  parts.object(free);
  EXPECT_EQ(free.modes, &modes);
  EXPECT_EQ(free.decay_rates, std::vector<double>(modes.size(), 0.0));
}

TEST(SupportsEffect, HoldWhatIsFixedInScenesThatMove) {
  EXPECT_EQ(read_effect("motion: {bodies: [{fixed: false}]}").reason_off,
            "nothing is fixed: what is free is held by what it touches");
  const SceneEffect effect = read_effect("motion:\n  bodies:\n    - {fixed: true}\n");
  EXPECT_EQ(effect.asked_by, "a body is fixed: (scene.yaml:3)");
  EXPECT_THROW(read_effect("{motion: {bodies: [{fixed: false}]}, supports: {contacts: [{kind: "
                           "table, lowest: true}]}}"),
               core::ConfigError);
}

TEST(SupportsEffect, RefusesWhatItCannotMean) {
  for (const char* wrong : {
           "contacts: []",
           "coupling: some, contacts: [{kind: finger, at: [0, 0, 5 cm]}]",
           "contacts: [{kind: fingr, at: [0, 0, 5 cm]}]",
           "contacts: [{kind: finger}]",
           "contacts: [{kind: finger, at: [0, 0, 5 cm], count: 2}]",
           "contacts: [{kind: finger, at: [0, 0]}]",
           "contacts: [{kind: string, along: [0, 0, 0, 1, 0, 0], count: 0}]",
           "contacts: [{kind: finger, at: [0, 0, 5 cm], radius: -1 mm}]",
           "contacts: [{kind: finger, at: [0, 0, 5 cm], force: 0 N}]",
           "contacts: [{kind: finger, at: [0, 0, 5 cm], force: 1 N, weight: true}]",
           "contacts: [{kind: table, lowest: true, down: [0, 0, 0]}]",
           "contacts: [{kind: finger, at: [0, 0, 5 cm], friction: -0.1}]",
           "contacts: [{coefficient: -1, friction: 0, at: [0, 0, 5 cm]}]",
           "contacts: [{coefficient: 1, at: [0, 0, 5 cm]}]",
           "contacts: [{stiffness: 1 kN/m, count: 2}]",
           "contacts: [{kind: rubber, count: 2, pool: 3}]",
           "contacts: [{kind: rubber, at: [0, 0, 5 cm], probability: 0.5}]",
           "contacts: [{kind: felt, at: [0, 0, 5 cm]}]",
           "contacts: [{stiffness: -1, at: [0, 0, 5 cm]}]",
           "contacts: [{resistance: -1, at: [0, 0, 5 cm]}]",
       }) {
    EXPECT_THROW(read_effect(std::string("supports: {") + wrong + "}"), core::ConfigError) << wrong;
  }
}

}  // namespace
}  // namespace carillon::scene
