// Copies of one object stay in one part of a split.
#include "dataset/plan/identities.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "core/temporary_folder.hpp"

namespace carillon::dataset {
namespace {

configuration::BuildConfig config_of(const std::string& objects, const std::string& more = "") {
  return configuration::read_build_config(
      "materials: [steel]\nobjects:\n" + objects + "split: {test: 0.5}\n" + more, "test.yaml", {});
}

/// A tetrahedron of given edges along the axes, turned about z and scaled.
std::string tetrahedron(double x, double y, double z, double angle, double scale) {
  const double c = std::cos(angle), s = std::sin(angle);
  std::string text = "OFF\n4 4 0\n";
  const double corners[4][3] = {{0, 0, 0}, {x, 0, 0}, {0, y, 0}, {0, 0, z}};
  for (const auto& p : corners) {
    text += fmt::format("{:.6g} {:.6g} {:.6g}\n", scale * (c * p[0] - s * p[1]),
                        scale * (s * p[0] + c * p[1]), scale * p[2]);
  }
  return text + "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
}

class Identities : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  configuration::BuildConfig meshes() const {
    return config_of("  - mesh: " + (folder_ / "*.off").string() + "\n");
  }
  core::TemporaryFolder own_;  // tests run side by side
  std::filesystem::path folder_ = own_.path();
};

TEST_F(Identities, TurnedAndScaledCopiesOfAMeshAreOneShape) {
  for (int i = 0; i < 20; ++i) {
    write(fmt::format("copy{:02}.off", i), tetrahedron(0.03, 0.04, 0.06, 0.3 * i, 1 + 0.1 * i));
  }
  const plan::BuildPlan plan = plan::make_plan(meshes());
  std::set<std::string> shapes, strikes, sums;
  for (const plan::Shape& shape : plan.shapes) {
    shapes.insert(shape.identity);
    strikes.insert(plan::split_strike(meshes(), shape, 3));
    sums.insert(shape.sha256);
  }
  EXPECT_EQ(sums.size(), 20U);
  EXPECT_EQ(shapes.size(), 1U);
  EXPECT_EQ(strikes.size(), 1U);
}

TEST_F(Identities, OtherMeshesAreOthersAndUnreadableOnesGoByTheirBytes) {
  write("a.off", tetrahedron(0.03, 0.04, 0.06, 0, 1));
  write("b.off", tetrahedron(0.03, 0.04, 0.061, 0, 1));
  write("c.off", "no mesh");
  write("d.off", "no mesh");
  write("e.off", "no mesh either");
  const auto shapes = plan::make_plan(meshes()).shapes;
  EXPECT_NE(shapes[0].identity, shapes[1].identity);
  EXPECT_EQ(shapes[2].identity, shapes[2].sha256);
  EXPECT_EQ(shapes[2].identity, shapes[3].identity);
  EXPECT_NE(shapes[2].identity, shapes[4].identity);
}

TEST_F(Identities, OfAMeshDoesNotDependOnTheOthers) {
  write("m.off", tetrahedron(0.03, 0.04, 0.06, 0, 1));
  const std::string alone = plan::make_plan(meshes()).shapes.front().identity;
  for (int i = 0; i < 5; ++i) {
    write(fmt::format("a{}.off", i), tetrahedron(0.03, 0.04, 0.05 + 0.002 * i, 0, 1));
  }
  EXPECT_EQ(plan::make_plan(meshes()).shapes.back().identity, alone);
}

TEST(GeneratedIdentities, AreThoseOfProportions) {
  const auto shapes =
      plan::make_plan(
          config_of("  - shape: bar\n    name: one\n    parameters: {length: 20 cm, width: 2 cm, "
                    "height: 1 cm}\n"
                    "  - shape: bar\n    name: double\n    parameters: {length: 40 cm, width: 4 "
                    "cm, height: 2 cm}\n"
                    "  - shape: bar\n    name: other\n    parameters: {length: 40 cm, width: 4 "
                    "cm, height: 1 cm}\n"
                    "  - shape: bar\n    name: drawn\n    count: 3\n"))
          .shapes;
  EXPECT_EQ(shapes[0].identity, shapes[0].id);
  EXPECT_EQ(shapes[1].identity, shapes[0].id);
  EXPECT_EQ(shapes[2].identity, shapes[2].id);
  for (std::size_t i = 3; i < 6; ++i) EXPECT_EQ(shapes[i].identity, shapes[i].id);
}

TEST(GivenStrikeIdentities, AtOnePointStayTogether) {
  configuration::BuildConfig config = config_of("  - shape: bar\n");
  for (int i = 0; i < 40; ++i) {
    config.scene.strikes.given.push_back({"*", {0.001 * (i % 20), 0, 0}, {}, 0.01, 0.001 * i});
  }
  const plan::Shape shape = plan::make_plan(config).shapes.front();
  std::set<std::string> parts;
  for (int i = 0; i < 20; ++i) {
    parts.insert(plan::split_strike(config, shape, i));
    EXPECT_EQ(plan::split_strike(config, shape, i), plan::split_strike(config, shape, i + 20)) << i;
  }
  EXPECT_GT(parts.size(), 1U);
}

}  // namespace
}  // namespace carillon::dataset
