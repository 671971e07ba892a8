#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "core/error.hpp"
#include "core/hdf5.hpp"
#include "core/temporary_folder.hpp"
#include "scene/columns.hpp"
#include "scene/effects/detail/list.hpp"
#include "scene/scene.hpp"

namespace carillon::scene {

namespace {

double at_hertz(double f) {
  return std::pow(2 * std::numbers::pi * f, 2);
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

SceneEffect read(const std::string& text, const std::vector<std::string>& materials) {
  core::ConfigNode root = core::ConfigNode::parse(text, "test.yaml");
  Scene scene;
  for (const std::string& name : materials) {
    scene.materials.push_back(synth::material::parse_material(name));
  }
  SceneEffect effect = damping_effect.read(root, scene);
  root.finish();
  return effect;
}

/// An object with modes at 500, 900, 2,500 and 3,100 Hz, of whom the model lets the second and
/// third grow: c is a parabola with roots at 800 and 3,000 Hz.
struct Growing {
  solvers::modes::Modes modes;
  std::vector<synth::material::Material> materials = {synth::material::parse_material("steel")};
  RingingObject object;

  Growing() {
    const double l1 = at_hertz(800), l2 = at_hertz(3000);
    materials[0].damping = {
        synth::damping::DampingKind::caughey, {1e-15 * l1 * l2, -1e-15 * (l1 + l2), 1e-15}, ""};
    for (const double f : {500.0, 900.0, 2500.0, 3100.0}) modes.eigenvalues.push_back(at_hertz(f));
    modes.kinetic_fraction = modes.strain_fraction = Eigen::MatrixXd::Ones(4, 1);
    object.id = "plate/own/1";
    object.modes = &modes;
    object.materials = &materials;
  }
  Sound sound(core::Columns* record) const {
    Sound made;
    made.object = &object;
    made.rings.eigenvalues = modes.eigenvalues;
    made.rings.decay_rates = object.decay_rates;
    made.rings.excitation = Eigen::VectorXd::Ones(4);
    made.rings.readout.velocity = Eigen::MatrixXd::Ones(1, 4);
    made.rings.readout.delays = {0};
    made.record = record;
    return made;
  }
};

TEST(DampingEffect, IsAskedForByMaterials) {
  EXPECT_EQ(read("{}", {"steel", "sterling_wood_hybrid"}).asked_by, "every material has damping");
  const std::string undamped = "youngs_modulus=1e9,poisson_ratio=0.3,density=1000";
  EXPECT_EQ(read("{}", {"steel", undamped}).asked_by, "1 of 2 materials have damping");
  const SceneEffect off = read("{}", {undamped});
  EXPECT_EQ(off.asked_by, "");
  EXPECT_EQ(off.reason_off, "no material has damping");
  EXPECT_EQ(read("{}", {"steel"}).reason_off, "");
}

TEST(DampingEffect, RefusesOtherChoices) {
  try {
    read("negative_damping: clam\n", {"steel"});
    FAIL() << "no error";
  } catch (const core::ConfigError& error) {
    EXPECT_TRUE(contains(error.what(), "test.yaml:1:")) << error.what();
    EXPECT_TRUE(contains(error.what(), "clamp")) << error.what();
  }
}

TEST(DampingEffect, SetsTheRatesOfAnObject) {
  Growing g;
  g.materials[0] = synth::material::parse_material("gpd_aluminum_power");
  const EffectParts parts = read("{}", {"steel"}).start("");
  EXPECT_FALSE(parts.rings);
  EXPECT_FALSE(parts.audio);
  parts.object(g.object);
  ASSERT_EQ(g.object.decay_rates.size(), 4u);
  const double omega = 2 * std::numbers::pi * 2500;
  EXPECT_NEAR(g.object.decay_rates[2], 0.02 * std::pow(omega, 0.89) / 2, 1e-10);
}

TEST(DampingEffect, NegativeIsAnErrorThatNamesTheObjectUnlessChosen) {
  Growing g;
  try {
    read("{}", {"steel"}).start("").object(g.object);
    FAIL() << "no error";
  } catch (const core::InputError& error) {
    EXPECT_TRUE(contains(error.what(), "plate/own/1: ")) << error.what();
    EXPECT_TRUE(contains(error.what(), "from 900 to 2500 Hz")) << error.what();
  }
}

TEST(DampingEffect, ClampLetsSuchModesRingUndamped) {
  Growing g;
  const EffectParts parts = read("negative_damping: clamp\n", {"steel"}).start("");
  parts.object(g.object);
  EXPECT_EQ(g.object.decay_rates[1], 0);
  EXPECT_EQ(g.object.decay_rates[2], 0);
  EXPECT_GT(g.object.decay_rates[0], 0);
  Sound sound = g.sound(nullptr);
  parts.rings(sound);
  EXPECT_EQ(sound.rings.excitation, Eigen::VectorXd::Ones(4));
}

TEST(DampingEffect, DropLeavesSuchModesOutAndSaysWhere) {
  Growing g;
  const EffectParts parts = read("negative_damping: drop\n", {"steel"}).start("");
  parts.object(g.object);
  core::Columns record(columns());
  Sound sound = g.sound(&record);
  parts.rings(sound);
  EXPECT_EQ(sound.rings.excitation, Eigen::Vector4d(1, 0, 0, 1));
  EXPECT_EQ(sound.rings.readout.velocity, Eigen::RowVector4d(1, 0, 0, 1));
  EXPECT_EQ(synth::modal::sounding_modes(sound.rings, 44100), 2u);
  // An object without such modes gives the same columns.
  Growing sane;
  sane.object.id = "plate/steel/1";
  sane.materials[0] = synth::material::parse_material("steel");
  parts.object(sane.object);
  Sound other = sane.sound(&record);
  parts.rings(other);
  EXPECT_EQ(other.rings.excitation, Eigen::Vector4d::Ones());

  const core::TemporaryFolder folder;
  const core::Hdf5Group file = core::Hdf5Group::create_file(folder / "record.h5");
  record.write(file);
  EXPECT_EQ(file.read<std::int64_t>("negative_damping_modes"), (std::vector<std::int64_t>{2, 0}));
  EXPECT_NEAR(file.read<double>("negative_damping_low").at(0), 900, 1e-9);
  EXPECT_NEAR(file.read<double>("negative_damping_high").at(0), 2500, 1e-9);
  EXPECT_TRUE(std::isnan(file.read<double>("negative_damping_low").at(1)));
}

}  // namespace
}  // namespace carillon::scene
