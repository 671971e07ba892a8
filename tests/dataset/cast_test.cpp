#include "dataset/samples/cast.hpp"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "core/error.hpp"
#include "dataset/samples/detail/simulation_parts.hpp"

namespace carillon::dataset {
namespace {

configuration::BuildConfig scene_of(const std::string& motion, int bars) {
  return configuration::read_build_config(
      "objects:\n  - {name: bars, shape: bar, materials: [steel], count: " + std::to_string(bars) +
          "}\nsplit: {validation: 0.3, test: 0.3}\n" + motion,
      "scene.yaml", {});
}

const char* const one_bar =
    "motion:\n  simulations: 60\n  bodies: [{object: bars, at: [0, 0, 0.1]}]\n";

// What is tested on has not been learned from.
TEST(Cast, InstancesAreKeptToTheirPart) {
  const configuration::BuildConfig config = scene_of(one_bar, 30);
  const plan::BuildPlan plan = plan::make_plan(config);
  ASSERT_TRUE(samples::held_out(config, plan, "bars"));
  std::map<std::string, std::set<std::size_t>> played;
  for (const plan::Sample& sample : plan.samples) {
    const std::string part = samples::split_of_simulation(config, sample);
    const std::vector<samples::Role> roles = samples::draw_roles(config, plan, sample.id, part);
    EXPECT_EQ(plan.shapes[roles.at(0).shape].split_shape, part);
    played[part].insert(roles[0].shape);
  }
  EXPECT_EQ(played.size(), 3u);
  EXPECT_GT(played["train"].size(), 3u);
}

// One body cannot be in one part only: all takes share it, and none claims otherwise.
TEST(Cast, TooFewInstancesAreShared) {
  const configuration::BuildConfig config = scene_of(one_bar, 2);
  const plan::BuildPlan plan = plan::make_plan(config);
  ASSERT_FALSE(samples::held_out(config, plan, "bars"));
  std::map<std::string, std::set<std::size_t>> played;
  for (const plan::Sample& sample : plan.samples) {
    const std::string part = samples::split_of_simulation(config, sample);
    played[part].insert(samples::draw_roles(config, plan, sample.id, part).at(0).shape);
  }
  for (const auto& [part, shapes] : played) EXPECT_EQ(shapes.size(), 2u) << part;
}

solvers::mesh::SurfaceMesh tetrahedron() {
  solvers::mesh::SurfaceMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

TEST(Textures, LieOnFlatSidesOnly) {
  scene::motion::TextureConfig texture;
  texture.map = "grooves";
  texture.texels = 64;
  texture.axis = 'z';
  scene::motion::Textures textures(0);
  const solvers::mesh::SurfaceMesh mesh = tetrahedron();
  const solvers::mesh::Box box = solvers::mesh::bounding_box(mesh.vertices);
  texture.towards_plus = false;
  const render::maps::TexturedFace under = textures.on(texture, box, &mesh);
  EXPECT_EQ(under.normal(), Vec3(0, 0, -1));
  texture.towards_plus = true;
  try {
    textures.on(texture, box, &mesh);
    FAIL() << "a tip is no face";
  } catch (const core::InputError& error) {
    EXPECT_NE(error.message().find("side +z is not flat (0 %"), std::string::npos)
        << error.message();
  }
}

TEST(Textures, AreShallowerThanHalfTheirBody) {
  scene::motion::TextureConfig texture;
  texture.map = "grooves";
  texture.texels = 64;
  texture.axis = 'z';
  texture.towards_plus = true;
  texture.parameters = {{"depth", 0.01}, {"wavelength", 0.02}, {"waves", 2}};
  scene::motion::Textures textures(0);
  EXPECT_NO_THROW(textures.on(texture, {{0, 0, 0}, {0.1, 0.1, 0.021}}));
  try {
    textures.on(texture, {{0, 0, 0}, {0.1, 0.1, 0.019}});
    FAIL() << "cut through";
  } catch (const core::InputError& error) {
    EXPECT_NE(error.message().find("9.95 mm deep, the body 19 mm thick"), std::string::npos)
        << error.message();
  }
}

TEST(MotionConfig, WhatIsFixedIsHeld) {
  const auto held_by = [](const std::string& body, const std::string& more = "") {
    return scene_of("motion: {bodies: [{object: bars, " + body + "}]}\n" + more, 1)
        .motion->bodies.front()
        .held_by;
  };
  EXPECT_EQ(held_by("fixed: false"), nullptr);
  const auto standing = held_by("fixed: true, rests: foam");
  ASSERT_TRUE(standing);
  EXPECT_EQ(standing->contacts.at(0).kind.name, "foam");
  EXPECT_EQ(standing->contacts.at(0).place, scene::SupportConfig::Place::lowest);
  const char* const by_all = "supports: {contacts: [{kind: rubber, at: [0, 0, 0]}]}\n";
  EXPECT_EQ(held_by("fixed: true", by_all)->contacts.at(0).kind.name, "rubber");
  EXPECT_EQ(held_by("fixed: true, supports: {contacts: [{kind: soil, lowest: true}]}", by_all)
                ->contacts.at(0)
                .kind.name,
            "soil");
  for (const char* wrong :
       {"fixed: false, supports: {contacts: [{kind: soil, lowest: true}]}", "rests: soil",
        "fixed: true, supports: {contacts: [{kind: table, count: 2}]}",
        "fixed: true, supports: {contacts: [{kind: finger, at: [0, 0, 0]}]}",
        "fixed: true, supports: {coupling: full, contacts: [{kind: soil, lowest: true}]}"}) {
    EXPECT_THROW(held_by(wrong), core::ConfigError) << wrong;
  }
}

TEST(MotionConfig, MorePicturedBodiesThanMasksCanTellAreRefused) {
  if (render::offscreen() == "none") GTEST_SKIP() << "built without pictures";
  const auto with = [](int count, bool camera) {
    return scene_of("motion:\n  bodies: [{object: bars, at: [0, 0, 1], repeat: {count: " +
                        std::to_string(count) + ", offset: [1, 0, 0]}}]\n" +
                        (camera ? "  camera: {eye: [1, 1, 1]}\n" : ""),
                    1);
  };
  EXPECT_NO_THROW(with(256, false));
  EXPECT_NO_THROW(with(255, true));
  EXPECT_THROW(with(256, true), core::ConfigError);
}

}  // namespace
}  // namespace carillon::dataset
