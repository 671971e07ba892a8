#include <gtest/gtest.h>

#include "../synth/scraped_face.hpp"
#include "core/error.hpp"
#include "dataset/configuration/configuration.hpp"
#include "dataset/samples/drawn_stylus.hpp"

namespace carillon::scene {
namespace {

dataset::configuration::BuildConfig config_of(const std::string& keys) {
  return dataset::configuration::read_build_config(
      "seed: 1\n"
      "objects:\n  - {shape: tile, name: plate, materials: [ceramic]}\n"
      "motion:\n  bodies:\n    - {object: plate, fixed: true, texture: {map: pebbles}}\n"
      "  stylus:\n    body: plate\n    path: [{u: 10 mm, v: 10 mm}, {u: 40 mm, v: 30 mm}]\n" +
          keys,
      "test.yaml", {});
}

/// Forces of a simulation in which the configured stylus is drawn over a sine.
std::vector<Vec3> forces_of(const dataset::configuration::BuildConfig& config) {
  dataset::samples::SimulationStage stage;
  stage.names = {"plate"};
  stage.actors = {nullptr};
  stage.sounding.resize(1);
  stage.moving.resize(1);
  stage.moving[0].fixed = true;
  stage.moving[0].texture.emplace();
  stage.moving[0].texture->map =
      std::make_shared<const render::maps::SurfaceMap>(synth::sine_map(2e-3, 2e-4, 32, 4));
  stage.moving[0].texture->size = {0.05, 0.05};
  synth::motion::Motion motion;
  motion.step = 1e-3;
  motion.left = {1e9};
  motion.states.assign(300, std::vector<synth::motion::BodyState>(1));
  return dataset::samples::draw_stylus(config, 0, stage, motion, nullptr).forces;
}

TEST(StylusConfig, EveryKeyReachesTheForces) {
  struct Case {
    const char* key;
    const char* text;
    double synth::touch::Stylus::*member;
    double value;  ///< SI
  };
  const Case cases[] = {
      {"mass", "30 g", &synth::touch::Stylus::mass, 0.03},
      {"radius", "0.5 mm", &synth::touch::Stylus::radius, 5e-4},
      {"hold_stiffness", "2 kN/m", &synth::touch::Stylus::hold, 2000},
      {"hold_damping", "3 N s/m", &synth::touch::Stylus::hold_damping, 3},
      {"press", "700 mN", &synth::touch::Stylus::press, 0.7},
      {"face_stiffness", "3 N/mm", &synth::touch::Stylus::stiffness, 3000},
      {"face_damping", "1 N s/m", &synth::touch::Stylus::damping, 1},
      {"friction", "0.2", &synth::touch::Stylus::friction, 0.2},
      {"max_force", "0.9 N", &synth::touch::Stylus::largest_force, 0.9},
  };
  const dataset::configuration::BuildConfig plain = config_of("");
  const auto usual = forces_of(plain);
  EXPECT_EQ(forces_of(plain), usual);
  for (const Case& one : cases) {
    SCOPED_TRACE(one.key);
    const dataset::configuration::BuildConfig config =
        config_of("    " + std::string(one.key) + ": " + one.text + "\n");
    EXPECT_EQ(config.motion->stylus->stylus.*one.member, one.value);
    EXPECT_EQ(plain.motion->stylus->stylus.*one.member, synth::touch::Stylus{}.*one.member);
    const auto forces = forces_of(config);
    double change = 0;
    for (std::size_t k = 0; k < usual.size(); ++k) {
      change = std::max(change, (forces[k] - usual[k]).norm());
    }
    EXPECT_GT(change, 0.01);
  }
}

TEST(StylusConfig, RefusesWhatCannotBe) {
  const auto refusal = [](const std::string& key, const std::string& text) -> std::string {
    try {
      config_of("    " + key + ": " + text + "\n");
    } catch (const core::ConfigError& error) {
      return error.what();
    }
    return "accepted";
  };
  for (const char* key : {"mass", "hold_stiffness", "face_stiffness", "max_force"}) {
    EXPECT_NE(refusal(key, "0").find(std::string(key) + ": must be positive"), std::string::npos)
        << refusal(key, "0");
  }
  for (const char* key : {"radius", "hold_damping", "press", "face_damping", "friction"}) {
    EXPECT_EQ(refusal(key, "0"), "accepted") << key;
    EXPECT_NE(refusal(key, "-1").find(std::string(key) + ": must not be negative"),
              std::string::npos)
        << refusal(key, "-1");
  }
  EXPECT_NE(refusal("hold_stiffness", "3 N").find("is a force; a stiffness is wanted"),
            std::string::npos);
}

}  // namespace
}  // namespace carillon::scene
