#include "dataset/configuration/configuration.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.hpp"
#include "core/text.hpp"
#include "render/frame.hpp"

namespace carillon::dataset {
namespace {

constexpr const char* minimal = R"(
objects:
  - shape: bar
    materials: [steel]
)";

configuration::BuildConfig read(const std::string& text,
                                const std::vector<std::string>& overrides = {}) {
  return configuration::read_build_config(text, "test.yaml", overrides);
}

/// Message of the ConfigError that a text gives.
std::string refusal(const std::string& text) {
  try {
    read(text);
  } catch (const core::ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Configuration, DefaultsAreThoseOfTheGuide) {
  const configuration::BuildConfig config = read(minimal);
  EXPECT_EQ(config.name, "test");
  EXPECT_EQ(config.seed, 0u);
  EXPECT_EQ(config.band.min_frequency, 20);
  EXPECT_EQ(config.band.max_frequency, 20000);
  EXPECT_EQ(config.band.max_modes, 300);
  EXPECT_EQ(config.scene.audio.samples(), 44100u);
  EXPECT_FALSE(config.mel || config.voxels || config.wav || config.png);
  EXPECT_TRUE(config.cameras.empty());
  EXPECT_TRUE(config.scene.listeners.empty());
}

// A family may have a usual material; names in the configuration come first.
TEST(Configuration, ABellIsOfBellBronzeWhereNoMaterialIsNamed) {
  using Names = std::vector<std::string>;
  const auto materials = [](const std::string& text) {
    return read(text).objects.front().object.materials;
  };
  EXPECT_EQ(materials("objects: [{shape: bell}]\n"), Names{"bell_bronze"});
  EXPECT_NE(read("objects: [{shape: bell}]\n").resolved.find("bell_bronze"), std::string::npos);
  EXPECT_EQ(materials("objects: [{shape: bell, materials: [iron]}]\n"), Names{"iron"});
  EXPECT_EQ(materials("objects: [{shape: bell}]\nmaterials: [steel, glass]\n"),
            (Names{"steel", "glass"}));
  EXPECT_NE(refusal("objects: [{shape: bowl}]\n").find("no material is named"), std::string::npos);
}

TEST(Configuration, ResolvedTextReadsBackAsItself) {
  if (render::offscreen() == "none") GTEST_SKIP() << "built without pictures";
  const std::string text = std::string(minimal) +
                           "mel: {}\nvoxels: {}\ncamera: {}\nlisteners:\n"
                           "  - position: [0, 0, 1 m]\nstrikes: {impulse: 20 mN s}\n";
  const configuration::BuildConfig once = read(text);
  const configuration::BuildConfig twice = read(once.resolved);
  EXPECT_EQ(once.resolved, twice.resolved);
  EXPECT_EQ(twice.mel->hop, 1837);
  EXPECT_EQ(twice.scene.strikes.impulse.low, 0.02);
}

TEST(Configuration, PicturesAreRefusedWhereNoneAreDrawn) {
  const std::string text = std::string(minimal) + "camera: {}\n";
  if (render::offscreen() != "none") {
    EXPECT_EQ(refusal(text), "accepted");
    return;
  }
  EXPECT_NE(refusal(text).find("camera: this program was built without pictures"),
            std::string::npos);
  EXPECT_NE(refusal(text).find("-DCARILLON_RENDER=ON"), std::string::npos);
  EXPECT_EQ(refusal(text + "effects: {frames: off}\n"), "accepted");
  // A stored dataset that has some can still be read.
  EXPECT_FALSE(configuration::read_build_config(text, "test.yaml", {}, scene::effects(), false)
                   .cameras.empty());
}

TEST(Configuration, ViewsAreEvenStepsOrAList) {
  if (render::offscreen() == "none") GTEST_SKIP() << "built without pictures";
  const auto cameras = [](const std::string& camera) {
    return read(std::string(minimal) + "camera: {azimuth: 0.5, elevation: 0.2, " + camera + "}\n")
        .cameras;
  };
  const auto four = cameras("views: 4");
  ASSERT_EQ(four.size(), 4U);
  for (std::size_t v = 0; v < 4; ++v) {
    EXPECT_NEAR(four[v].azimuth, 0.5 + 1.5707963 * static_cast<double>(v), 1e-6);
    EXPECT_EQ(four[v].elevation, 0.2);
  }
  const auto listed = cameras("width: 20, views: [{}, {azimuth: 90 deg}, {elevation: 1}]");
  ASSERT_EQ(listed.size(), 3U);
  EXPECT_EQ(listed[0].azimuth, 0.5);
  EXPECT_NEAR(listed[1].azimuth, 1.5707963, 1e-6);
  EXPECT_EQ(listed[1].elevation, 0.2);
  EXPECT_EQ(listed[2].elevation, 1);
  EXPECT_EQ(listed[2].width, 20);
  for (const char* wrong : {"views: 0", "views: []", "views: [{distance: 1 m}]", "views: many"}) {
    EXPECT_NE(refusal(std::string(minimal) + "camera: {" + wrong + "}\n").find("views"),
              std::string::npos)
        << wrong;
  }
}

TEST(Configuration, UnitsAreUnderstood) {
  const configuration::BuildConfig config = read(
      "objects:\n  - shape: bar\n    materials: steel\n    parameters: {length: [12 cm, 200 mm]}\n"
      "modes: {max_frequency: 12 kHz}\naudio: {seconds: 500 ms}\n");
  EXPECT_DOUBLE_EQ(config.objects[0].object.parameters.at("length").low, 0.12);
  EXPECT_DOUBLE_EQ(config.objects[0].object.parameters.at("length").high, 0.2);
  EXPECT_DOUBLE_EQ(config.band.max_frequency, 12000);
  EXPECT_EQ(config.scene.audio.samples(), 22050u);
}

TEST(Configuration, MistakesNamePlaceAndRemedy) {
  EXPECT_NE(refusal("objects:\n  - shape: bar\n    lenght: 3\n    materials: [steel]\n")
                .find("test.yaml:3:5: objects[0].lenght"),
            std::string::npos);
  EXPECT_NE(refusal("objects:\n  - shape: bra\n    materials: [steel]\n").find("\"bar\""),
            std::string::npos);
  EXPECT_NE(refusal("objects:\n  - shape: bar\n    materials: [stele]\n").find("steel"),
            std::string::npos);
  EXPECT_NE(refusal(std::string(minimal) + "audio: {seconds: 3 kg}\n").find("audio.seconds"),
            std::string::npos);
  EXPECT_NE(refusal("objects:\n  - shape: bar\n    mesh: a.obj\n    materials: [steel]\n")
                .find("objects[0]"),
            std::string::npos);
  EXPECT_NE(refusal("objects: []\n").find("no objects"), std::string::npos);
  EXPECT_NE(refusal("objects:\n  - shape: bar\n").find("no material"), std::string::npos);
}

TEST(Configuration, ImpossibleValuesAreRefused) {
  const std::string text(minimal);
  for (const char* wrong :
       {"modes: {min_frequency: 30 kHz}\n", "audio: {gain: 0}\n", "audio: {sample_rate: 10 Hz}\n",
        "strikes: {spread: 90 deg}\n", "strikes: {impulse: 0}\n",
        "split: {test: 0.7, validation: 0.4}\n", "mel: {max_frequency: 30 kHz}\n",
        "camera: {field_of_view: 180 deg}\n", "audio: {seconds: 0}\n",
        "strikes: {csv: not-there.csv}\n", "solver: {memory_limit: 1e12 GiB}\n",
        "solver: {memory_limit: -1 GiB}\n", "solver: {memory_limit: 0}\n",
        "limits: {mesh_memory: 1e300}\n"}) {
    EXPECT_NE(refusal(text + wrong), "accepted") << wrong;
  }
}

TEST(Configuration, LimitsOfMemoryNeverOverflow) {
  const std::string text = refusal(std::string(minimal) + "solver: {memory_limit: 1e12 GiB}\n");
  EXPECT_NE(text.find("solver.memory_limit"), std::string::npos) << text;
  EXPECT_NE(text.find("16 GiB"), std::string::npos) << text;
  EXPECT_EQ(read(std::string(minimal) + "solver: {memory_limit: 1 MiB}\n").solver.memory_limit,
            1 << 20);
  EXPECT_EQ(core::whole_bytes(1152921504606846976.0), 1ll << 60);
  EXPECT_THROW(core::whole_bytes(1e21), core::InputError);
  EXPECT_THROW(core::whole_bytes(std::nan("")), core::InputError);
}

TEST(Configuration, MaterialsOfGroups) {
  const configuration::BuildConfig config =
      read("objects:\n  - mesh: a.msh\n    materials: {shell: steel, core: wood}\n");
  EXPECT_EQ(config.objects[0].object.groups.at("core"), "wood");
  EXPECT_TRUE(config.objects[0].object.materials.empty());
  for (const char* one : {"shape: bar", "mesh: a.obj"}) {
    const std::string object = std::string("objects:\n  - ") + one + "\n    materials: ";
    EXPECT_NE(refusal(object + "{shell: steel, core: wood}\n").find("objects[0].materials"),
              std::string::npos);
    EXPECT_NO_THROW(read(object + "{body: steel}\n"));
  }
}

TEST(Configuration, OverridesWin) {
  EXPECT_EQ(read(minimal, {"strikes.per_object=3"}).scene.strikes.per_object, 3);
  EXPECT_EQ(read(minimal, {"objects[0].count=7"}).objects[0].count, 7);
}

TEST(Configuration, TurnedProfilesFromPoints) {
  const configuration::BuildConfig config = read(
      "objects:\n  - shape: turned\n    materials: [glass]\n    profile:\n"
      "      - {radius: 0, height: 0}\n      - {radius: 3 cm, height: 0}\n"
      "      - {radius: 3 cm, height: 2 cm}\n      - {radius: 0, height: 2 cm}\n");
  ASSERT_EQ(config.objects[0].object.profile.size(), 4u);
  EXPECT_DOUBLE_EQ(config.objects[0].object.profile[2][0], 0.03);
}

}  // namespace
}  // namespace carillon::dataset
