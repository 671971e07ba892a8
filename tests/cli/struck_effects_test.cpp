// The effects striker, click and thrift as a configuration calls for them.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "../synth/curved_bodies.hpp"
#include "cli/sound/chain.hpp"
#include "cli/sound/effects/list.hpp"
#include "cli/sound/scene.hpp"
#include "synth/acceleration_click.hpp"
#include "synth/striker.hpp"

namespace carillon::cli {
namespace {

const Effect registry[] = {contact_effect, striker_effect, radiation_effect, thrift_effect,
                           click_effect};
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

/// A glass ball of two modes, struck on its pole; the sound of sample `id`.
struct Struck {
  solvers::Modes modes = synth::modes_with(synth::curved_sphere(0.03, {0, 0, 0}, 3, 2), {1e8, 4e8},
                                           [](int i, const solvers::Vec3& x) -> solvers::Vec3 {
                                             return (i == 0 ? 3.0 : 1e-6) * x.normalized();
                                           });
  std::vector<synth::Material> materials = {synth::parse_material("glass")};
  synth::SurfaceSampler sampler{modes.surface};
  core::Trace trace;
  Columns record;
  RingingBody body;
  Sound sound;

  explicit Struck(const Scene& scene, std::uint64_t id = 1) {
    modes.mass = 0.28;
    SoundChain chain(scene, {}, trace);
    body = chain.prepare("ball", modes, materials, sampler);
    sound.body = &body;
    sound.id = id;
    sound.strike.point = sampler.nearest({0, 0, 0.03});
    sound.strike.direction = {0, 0, -1};
    sound.strike.impulse = 0.01;
    sound.contact_time = 2e-4;
    sound.record = &record;
    chain.make(sound);
  }
};

TEST(StruckEffects, AreOffUnlessCalledFor) {
  const Scene scene = scene_of("");
  for (const char* name : {"striker", "click", "thrift"}) {
    EXPECT_FALSE(decision(scene, name).enabled) << name;
    EXPECT_FALSE(decision(scene, name).reason.empty()) << name;
  }
  const Struck struck(scene);
  EXPECT_EQ(struck.sound.strike.impulse, 0.01);
  for (const char* name : {"striker", "click", "thrift"}) {
    EXPECT_EQ(struck.trace.effects.count(name), 0u) << name;
  }
}

TEST(StruckEffects, StrikerSetsImpulseAndDurationByHertz) {
  const Scene scene = scene_of("striker: {kind: metal, speed: 1.5 m/s}\n");
  EXPECT_EQ(decision(scene, "striker").reason, "striker: (scene.yaml:1)");
  const Struck struck(scene);
  const synth::HertzContact contact =
      synth::hertz_contact(synth::preset_striker("metal"), {0.28, 6.2e10, 0.2, 0}, 1.5);
  EXPECT_DOUBLE_EQ(struck.sound.strike.impulse, contact.impulse);
  EXPECT_DOUBLE_EQ(struck.sound.strike.force.duration, contact.duration);
  EXPECT_DOUBLE_EQ(struck.sound.contact_time, contact.duration);
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
  EXPECT_THROW(scene_of("striker: {kind: metal, mass: 1 g, density: 1000}\n"), core::ConfigError);
  EXPECT_THROW(scene_of("striker: {kind: noise_burst, size: 2}\n"), core::ConfigError);
}

TEST(StruckEffects, ClickAddsTheBodysJumpToThePressure) {
  const Struck without(scene_of(listener + "effects: {click: off}\n"));
  const Struck with(scene_of(listener));
  const auto click =
      synth::acceleration_click(synth::rigid_source(with.modes.surface, 0.28), {0, 0, -0.01},
                                with.sound.strike.force, {0, 0, 1}, 44100, with.sound.audio.size());
  float largest = 0;
  for (std::size_t n = 0; n < click.size(); ++n) {
    EXPECT_EQ(with.sound.audio[n], without.sound.audio[n] + click[n]);
    largest = std::max(largest, std::abs(click[n]));
  }
  EXPECT_GT(largest, 0.0f);
}

TEST(StruckEffects, ClickIsOffWhereTheBodyIsHeld) {
  EXPECT_FALSE(decision(scene_of(listener + "click: {held: true}\n"), "click").enabled);
  const Scene supported = scene_of(listener + "supports: [{}]\n");
  EXPECT_FALSE(decision(supported, "click").enabled);
  EXPECT_NE(decision(supported, "click").reason.find("scene.yaml:2"), std::string::npos);
  EXPECT_TRUE(
      decision(scene_of(listener + "supports: [{}]\nclick: {held: false}\n"), "click").enabled);
}

TEST(StruckEffects, ThriftRunsOnDemandOnly) {
  EXPECT_FALSE(decision(scene_of("thrift: {margin: 6}\n"), "thrift").enabled);
  const Struck all(scene_of(""));
  const Struck few(scene_of("effects: {thrift: on}\n"));
  EXPECT_EQ(all.sound.rings.eigenvalues.size(), 2u);
  EXPECT_EQ(few.sound.rings.eigenvalues.size(), 1u);
  EXPECT_THROW(scene_of("thrift: {margin: -1}\n"), core::ConfigError);
}

}  // namespace
}  // namespace carillon::cli
