// The effects striker and click as a configuration calls for them.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "../synth/curved_bodies.hpp"
#include "scene/chain.hpp"
#include "scene/columns.hpp"
#include "scene/effects/detail/list.hpp"
#include "scene/scene.hpp"
#include "synth/contact/acceleration_click.hpp"
#include "synth/contact/noise_burst.hpp"
#include "synth/contact/striker.hpp"

namespace carillon::scene {
namespace {

const Effect registry[] = {striker_effect, contact_effect, radiation_effect, click_effect};
const std::string listener = "listeners: [{position: [0, 0, 1]}]\n";

Scene scene_of(const std::string& text) {
  auto root = core::ConfigNode::parse(text + "audio: {seconds: 0.05 s}\n", "scene.yaml");
  return read_scene(root, "scene.yaml", registry);
}

const EffectDecision& decision(const Scene& scene, std::string_view name) {
  for (const EffectDecision& d : scene.effects) {
    if (name == d.effect->name) return d;
  }
  throw std::runtime_error("no such effect");
}

/// @param flat  of its height is left
solvers::modes::Modes ball(double flat) {
  solvers::modes::Modes modes = synth::modes_with(
      synth::curved_sphere(0.03, {0, 0, 0}, 3, 2), {1e8, 4e8},
      [](int i, const Vec3& x) -> Vec3 { return (i == 0 ? 3.0 : 1e-6) * x.normalized(); });
  for (Vec3& node : modes.surface.nodes) node.z() *= flat;
  return modes;
}

/// A glass ball of two modes, struck on its pole; the sound of sample `id`.
struct Struck {
  solvers::modes::Modes modes;
  std::vector<synth::material::Material> materials = {synth::material::parse_material("glass")};
  synth::modal::SurfaceSampler sampler{modes.surface};
  core::Trace trace;
  core::Columns record{columns()};
  RingingObject object;
  Sound sound;

  explicit Struck(const Scene& scene, std::uint64_t id = 1, std::vector<double> strikes = {0},
                  double flat = 1)
      : modes(ball(flat)) {
    modes.mass = 0.28;
    SoundChain chain(scene, {}, trace);
    object = chain.prepare("ball", "ball", modes, materials);
    sound.object = &object;
    sound.id = id;
    sound.strike.point = sampler.nearest({0, 0, 0.03});
    sound.strike.direction = {0, 0, -1};
    sound.strike.impulse = 0.01;
    sound.contact_time = 2e-4;
    sound.record = &record;
    sound.strikes = std::move(strikes);
    chain.make(sound);
  }
};

TEST(StruckEffects, AreOffUnlessCalledFor) {
  const Scene scene = scene_of("");
  for (const char* name : {"striker", "click"}) {
    EXPECT_FALSE(decision(scene, name).enabled) << name;
    EXPECT_FALSE(decision(scene, name).reason.empty()) << name;
  }
  const Struck struck(scene);
  EXPECT_EQ(struck.sound.strike.impulse, 0.01);
  for (const char* name : {"striker", "click"}) {
    EXPECT_EQ(struck.trace.effects.count(name), 0u) << name;
  }
}

TEST(StruckEffects, StrikerSetsImpulseAndDurationByHertz) {
  const Scene scene = scene_of("striker: {kind: metal, speed: 1.5 m/s}\n");
  EXPECT_EQ(decision(scene, "striker").reason, "striker: (scene.yaml:1)");
  const Struck struck(scene);
  const synth::contact::HertzContact contact = synth::contact::hertz_contact(
      synth::contact::preset_striker("metal"), {0.28, 6.2e10, 0.2, 0}, 1.5);
  EXPECT_DOUBLE_EQ(struck.sound.strike.impulse, contact.impulse);
  EXPECT_DOUBLE_EQ(struck.sound.strike.force.duration, contact.duration);
}

TEST(StruckEffects, StrikersAreDrawnBySampleAndNothingElse) {
  const Scene scene = scene_of("striker: {kind: [metal, rubber, noise_burst]}\n");
  bool burst = false, pulse = false;
  for (std::uint64_t id = 0; id < 20; ++id) {
    const Struck once(scene, id), again(scene, id);
    EXPECT_EQ(once.sound.strike.impulse, again.sound.strike.impulse);
    EXPECT_EQ(once.sound.strike.force.samples, again.sound.strike.force.samples);
    EXPECT_EQ(once.sound.audio, again.sound.audio);
    (once.sound.strike.force.samples.empty() ? pulse : burst) = true;
  }
  EXPECT_TRUE(burst && pulse);
}

TEST(StruckEffects, StrikerRefusesWhatItCannotUse) {
  EXPECT_THROW(scene_of("striker: {kind: mettal}\n"), core::ConfigError);
  EXPECT_THROW(scene_of("striker: {kind: []}\n"), core::ConfigError);
  EXPECT_THROW(scene_of("striker: {kind: own, radius: 1 cm}\n"), core::ConfigError);
  EXPECT_THROW(scene_of("striker: {kind: metal, restitution: 2}\n"), core::ConfigError);
  EXPECT_THROW(scene_of("striker: {kind: metal, speed: -1}\n"), core::ConfigError);
  EXPECT_THROW(scene_of("striker: {kind: metal, speed: 0}\n"), core::ConfigError);
  EXPECT_THROW(scene_of("striker: {kind: metal, mass: 1 g, density: 1000}\n"), core::ConfigError);
  EXPECT_THROW(scene_of("striker: {kind: noise_burst, burst_size: 2}\n"), core::ConfigError);
}

// What programs that write YAML 1.1 make of on and off.
TEST(StruckEffects, ClickTakesTrueAndFalseForOnAndOff) {
  EXPECT_TRUE(decision(scene_of(listener + "effects: {click: true}\n"), "click").enabled);
  EXPECT_FALSE(decision(scene_of(listener + "effects: {click: false}\n"), "click").enabled);
  EXPECT_THROW(scene_of(listener + "effects: {click: perhaps}\n"), core::ConfigError);
}

TEST(StruckEffects, ClickAddsTheBodysJumpToThePressure) {
  const Struck without(scene_of(listener + "effects: {click: off}\n"));
  const Struck with(scene_of(listener));
  const auto click = synth::contact::acceleration_click(
      synth::contact::rigid_source(with.modes.surface, 0.28), {0, 0, -0.01},
      with.sound.strike.force, {0, 0, 1}, 44100, with.sound.audio.size());
  float largest = 0;
  for (std::size_t n = 0; n < click.size(); ++n) {
    EXPECT_EQ(with.sound.audio[n], without.sound.audio[n] + click[n]);
    largest = std::max(largest, std::abs(click[n]));
  }
  EXPECT_GT(largest, 0.0f);
}

// Nothing is known of a click inside the sphere that stands for the object.
TEST(StruckEffects, ListenersTooNearAreWithoutTheClickUnlessItIsAskedForByHand) {
  const std::string sources = "radiation: {min_sources: 40, max_sources: 40}\n";
  const std::string near =
      "listeners: [{position: [0, 0, 0.02]}, {position: [0, 0, 1]}]\n" + sources;
  const double flat = 0.3;  // 9 mm up to its pole, and a sphere of 23 mm stands for it
  const Struck with(scene_of(near), 1, {0}, flat);
  const Struck without(scene_of(near + "effects: {click: off}\n"), 1, {0}, flat);
  const std::size_t count = with.sound.audio.size() / 2;
  for (std::size_t n = 0; n < count; ++n) {
    ASSERT_EQ(with.sound.audio[n], without.sound.audio[n]) << n;
  }
  EXPECT_NE(
      std::vector(with.sound.audio.begin() + std::ptrdiff_t(count), with.sound.audio.end()),
      std::vector(without.sound.audio.begin() + std::ptrdiff_t(count), without.sound.audio.end()));
  EXPECT_EQ(with.record.last_row().at("click_left_out"), 1);
  EXPECT_GT(with.record.last_row().at("click_peak"), 0.0);
  const Struck alone(scene_of("listeners: [{position: [0, 0, 0.02]}]\n" + sources), 1, {0}, flat);
  EXPECT_EQ(alone.record.last_row().at("click_peak"), 0.0);
  try {
    const Struck refused(scene_of(near + "effects: {click: on}\n"), 1, {0}, flat);
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(error.message().find("0.02 m"), std::string::npos) << error.message();
    EXPECT_NE(error.hint().find("effects.click"), std::string::npos) << error.hint();
  }
}

TEST(StruckEffects, ClickIsOffWhereTheObjectIsHeld) {
  const Scene held = scene_of(listener + "click: {held: true}\n");
  EXPECT_FALSE(decision(held, "click").enabled);
  EXPECT_NE(decision(held, "click").reason.find("scene.yaml:2"), std::string::npos);
}

// Dashpots stop an object long after the contact: it jumps as if it were free.
TEST(StruckEffects, SupportsLeaveClickAndImpulseAsTheyAre) {
  const std::string text = listener + "striker: {kind: metal, speed: 1}\n";
  const Struck free(scene_of(text));
  const Struck supported(scene_of(text + "supports: {contacts: [{kind: table, force: 1 N}]}\n"));
  EXPECT_EQ(supported.sound.strike.impulse, free.sound.strike.impulse);
  EXPECT_EQ(supported.record.last_row()["click_peak"], free.record.last_row()["click_peak"]);
  EXPECT_GT(free.record.last_row()["click_peak"], 0.0);
  EXPECT_EQ(supported.sound.audio, free.sound.audio);
}

TEST(StruckEffects, EveryStrikeClicks) {
  const std::vector<double> strikes = {0.0123456, 0};
  const Struck without(scene_of(listener + "effects: {click: off}\n"), 1, strikes);
  const Struck with(scene_of(listener), 1, strikes);
  // What one strike adds, now and 0.0123456 s later: 0.0123456 s are 544.44 samples.
  const auto click = [&](double begin) {
    return synth::contact::acceleration_click(
        synth::contact::rigid_source(with.modes.surface, 0.28), {0, 0, -0.01},
        with.sound.strike.force, {0, 0, 1}, 44100, with.sound.audio.size(), begin);
  };
  const auto first = click(0), second = click(strikes[0]);
  float peak = 0, late = 0;
  for (std::size_t n = 0; n < first.size(); ++n) {
    peak = std::max(peak, std::abs(first[n]));
    if (n > 600) late = std::max(late, std::abs(second[n]));
    EXPECT_NEAR(with.sound.audio[n] - without.sound.audio[n], first[n] + second[n],
                1e-6 * std::abs(without.sound.audio[n]) + 1e-6 * peak)
        << n;
  }
  EXPECT_NEAR(late / peak, 1, 0.3);
}

TEST(StruckEffects, ASheetInABaffleDoesNotJump) {
  const std::string baffled = listener + "radiation: {model: rayleigh_integral}\n";
  const Scene scene = scene_of(baffled);
  EXPECT_FALSE(decision(scene, "click").enabled);
  EXPECT_NE(decision(scene, "click").reason.find("the sheet sits in a baffle"), std::string::npos);
  EXPECT_TRUE(decision(scene_of(baffled + "effects: {click: on}\n"), "click").enabled);
  EXPECT_TRUE(decision(scene_of(listener + "radiation: {model: monopole}\n"), "click").enabled);
  EXPECT_FALSE(decision(scene_of(listener + "effects: {radiation: off}\n"), "click").enabled);
}

double recorded(const Struck& struck, const char* column) {
  return struck.record.last_row().at(column).get<double>();
}

TEST(StruckEffects, PeakForceIsThatOfThePulseThatIsRendered) {
  for (const char* pulse : {"cosine", "hertz"}) {
    const Struck struck(
        scene_of(std::string("striker: {kind: wood, speed: 1, pulse: ") + pulse + "}\n"));
    const synth::modal::ContactForce& force = struck.sound.strike.force;
    const bool hertz = std::string(pulse) == "hertz";
    EXPECT_EQ(force.samples.empty(), !hertz);
    EXPECT_NEAR(
        recorded(struck, "striker_peak_force") * force.duration / struck.sound.strike.impulse,
        hertz ? 1.8397 : 2, 1e-3);
  }
}

TEST(StruckEffects, ABurstsImpulseIsItsIntegral) {
  const Struck struck(scene_of("striker: {kind: noise_burst}\n"));
  const synth::modal::ContactForce& force = struck.sound.strike.force;
  EXPECT_NEAR(synth::modal::impulse_of(force), 1, 1e-9);
  core::RandomStream noise(0, 1, "striker.noise");
  const synth::modal::ContactForce drawn = synth::contact::noise_burst({}, 44100, noise);
  EXPECT_NEAR(struck.sound.strike.impulse, 0.01 * synth::modal::impulse_of(drawn), 1e-12);
  for (std::size_t n = 0; n < drawn.samples.size(); ++n) {
    EXPECT_NEAR(struck.sound.strike.impulse * force.samples[n], 0.01 * drawn.samples[n],
                1e-12 * synth::modal::peak_of(drawn));
  }
  EXPECT_NEAR(recorded(struck, "striker_peak_force"), 0.01 * synth::modal::peak_of(drawn), 1e-9);
}

TEST(StruckEffects, ABallsMassFollowsItsRadius) {
  const auto mass = [](const std::string& more) {
    return recorded(Struck(scene_of("striker: {speed: 1, " + more + "}\n")),
                    "striker_effective_mass");
  };
  const auto with_object = [](double m) { return 1 / (1 / m + 1 / 0.28); };
  const double metal = synth::contact::preset_striker("metal").mass;
  EXPECT_NEAR(mass("kind: metal") / with_object(metal), 1, 1e-12);
  EXPECT_NEAR(mass("kind: metal, radius: 1 mm") / with_object(metal / 512), 1, 1e-12);
  EXPECT_NEAR(mass("kind: rubber, radius: 6 mm") /
                  with_object(synth::contact::preset_striker("rubber").mass / 8),
              1, 1e-12);
  EXPECT_NEAR(mass("kind: metal, radius: 1 mm, mass: 3 g") / with_object(0.003), 1, 1e-12);
  // A fingertip is no ball.
  EXPECT_NEAR(mass("kind: finger, radius: 1 mm") / with_object(0.02), 1, 1e-12);
}

TEST(StruckEffects, AnUnknownStrikerIsToldAllThereAre) {
  try {
    scene_of("striker: {kind: [metal, noise_brust]}\n");
    FAIL();
  } catch (const core::ConfigError& error) {
    EXPECT_NE(error.message().find("no striker \"noise_brust\""), std::string::npos);
    EXPECT_EQ(error.hint(),
              "did you mean \"noise_burst\"? there are metal, wood, rubber, finger, own, "
              "noise_burst");
  }
}

}  // namespace
}  // namespace carillon::scene
