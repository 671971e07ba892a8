// Scenes with one object more, however their lists are written; and what the papers' tables say.
#include "eval/studies/learning/recognised_scene.hpp"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "core/error.hpp"
#include "eval/studies/learning/detail/published_accuracies.hpp"

namespace carillon::eval {
namespace {

const studies::RecognisedObject cup{"cup-001", "shape: cup, parameters: {radius: 0.04}", "glass"};
const Eigen::Vector3d place(0.1, -0.05, 0.2);

void expect_one_more(const std::string& text) {
  const std::string longer = studies::with_object(text, "scene.yaml", cup, place);
  const YAML::Node before = YAML::Load(text), after = YAML::Load(longer);
  ASSERT_EQ(after["objects"].size(), before["objects"].size() + 1) << longer;
  ASSERT_EQ(after["motion"]["bodies"].size(), before["motion"]["bodies"].size() + 1) << longer;
  const YAML::Node object = after["objects"][0], body = after["motion"]["bodies"][0];
  EXPECT_EQ(object["name"].as<std::string>(), "recognised-cup-001");
  EXPECT_EQ(object["shape"].as<std::string>(), "cup");
  EXPECT_EQ(object["parameters"]["radius"].as<double>(), 0.04);
  EXPECT_EQ(object["materials"][0].as<std::string>(), "glass");
  EXPECT_EQ(body["object"].as<std::string>(), "recognised-cup-001");
  EXPECT_EQ(body["at"][1].as<double>(), -0.05);
  for (std::size_t i = 0; i < before["objects"].size(); ++i) {
    EXPECT_EQ(YAML::Dump(after["objects"][i + 1]), YAML::Dump(before["objects"][i]));
  }
  // What was written stays as it was written.
  std::size_t at = 0;
  for (const char c : text) {
    at = longer.find(c, at);
    ASSERT_NE(at, std::string::npos);
    ++at;
  }
}

TEST(RecognisedScene, TakesBlocksAndFlowsOfEntries) {
  expect_one_more(
      "# a scene\nobjects:\n  - {shape: bar}  # long\n  - shape: tile\n    count: 2\n"
      "motion:\n  bodies:\n    - object: bar\n      at: [0, 0, 1]\n");
  expect_one_more("objects:\n- {shape: bar}\nmotion:\n  bodies:\n  - {object: bar}\n");
  expect_one_more("motion: {bodies: [{object: bar}], simulations: 2}\nobjects: [{shape: bar}]\n");
  expect_one_more("{motion: {bodies: [{object: bar}]}, objects: [{shape: bar}]}");
  expect_one_more(
      "objects:\r\n  - {shape: bar}\r\nmotion:\r\n  bodies:\r\n    - {object: bar}\r\n");
}

TEST(RecognisedScene, RefusesWhatIsNoScene) {
  for (const char* text :
       {"", "[1]", "objects: [{shape: bar}]", "objects: []\nmotion: {bodies: []}",
        "objects: {a: 1}\nmotion: {bodies: [{object: bar}]}", "objects: [}"}) {
    EXPECT_THROW(studies::with_object(text, "scene.yaml", cup, place), core::InputError) << text;
  }
  const std::string once = studies::with_object(
      "objects: [{shape: bar}]\nmotion: {bodies: [{object: bar}]}\n", "s", cup, place);
  EXPECT_THROW(studies::with_object(once, "s", cup, place), core::InputError);
}

TEST(PublishedAccuracies, AreThoseOfTheTables) {
  // Sterling 2019: one of each of Tables 6.1 to 6.5.
  EXPECT_NEAR(studies::published_accuracy("rsa-r-geometry", "isnn-a").value(), 0.9237, 1e-12);
  EXPECT_NEAR(studies::published_accuracy("mn10osm-geometry", "soundnet8").value(), 0.2967, 1e-12);
  EXPECT_NEAR(studies::published_accuracy("mn40osm-geometry", "linear-svm-v").value(), 0.1206,
              1e-12);
  EXPECT_NEAR(studies::published_accuracy("mn10o-geometry", "isnn-av-bilinear").value(), 0.918,
              1e-12);
  EXPECT_NEAR(studies::published_accuracy("arnab-material", "soundnet5").value(), 0.4311, 1e-12);
  EXPECT_FALSE(studies::published_accuracy("mn10-geometry", "soundnet8").has_value());
  EXPECT_FALSE(studies::published_accuracy("rsa-s-material", "voxnet").has_value());
  EXPECT_EQ(studies::published_sets().size(), 15U);
}

}  // namespace
}  // namespace carillon::eval
