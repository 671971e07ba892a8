#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "family_shapes.hpp"
#include "mesh_checks.hpp"
#include "solvers/families/revolve.hpp"
#include "tests/solvers/written_files.hpp"

namespace carillon::test {
namespace {

using namespace solvers;
constexpr double pi = std::numbers::pi;

TEST(Turned, HasThePappusVolumeAndArea) {
  GeneratedShape shape;
  shape.family = "turned";
  for (int i = 0; i < 40; ++i) {  // a ring of round section, off the axis
    const double a = 2 * pi * i / 40;
    shape.profile.push_back({0.04 + 0.01 * std::cos(a), 0.01 * std::sin(a)});
  }
  const double section = 40 * 0.5 * 1e-4 * std::sin(2 * pi / 40);
  const double around = 2 * pi * 0.04;
  const auto torus = mesh_of(shape, 2);
  EXPECT_EQ(boundary_euler_number(torus.mesh), 0);
  EXPECT_NEAR(torus.quality.volume / (section * around), 1, 3e-3);
  EXPECT_NEAR(solvers::families::turned_volume(shape.profile) / (section * around), 1, 1e-12);
  const double girth = 40 * 2 * 0.01 * std::sin(pi / 40);
  EXPECT_NEAR(solvers::families::turned_area(shape.profile) / (girth * around), 1, 1e-12);
  EXPECT_NEAR(boundary_area(torus.mesh) / (girth * around), 1, 5e-3);
}

TEST(Turned, ConvergesToTheFormula) {
  GeneratedShape cone{"turned", {}, {{0, 0}, {0.05, 0}, {0.03, 0.06}, {0, 0.06}}};
  const double exact = pi * 0.06 / 3 * (25e-4 + 15e-4 + 9e-4);
  const auto errors = volume_errors(cone, 2, 0.03, exact);
  EXPECT_GT(errors[0] / errors[1], 8);
  EXPECT_LT(errors[1], 1e-4);
  // Nodes of the sharp rims lie on them, and all of the boundary on the cone and its ends.
  const auto mesh = mesh_of(cone, 2, 0.03).mesh;
  for (std::int32_t n : boundary_nodes(mesh)) {
    const Vec3& p = mesh.nodes[static_cast<std::size_t>(n)];
    const double side = std::abs(p.head<2>().norm() - (0.05 - p.z() / 3)) * 0.95;
    EXPECT_LT(std::min({side, std::abs(p.z()), std::abs(p.z() - 0.06)}), 1e-12);
  }
}

/// Circles between cones that meet at 5 to 18 degrees: elements over one would miss what lies about
/// it at every order, so that no estimate saw it.
TEST(Turned, SlightCornersAreKept) {
  const GeneratedShape shape{"turned",
                             {},
                             {{0, 0},
                              {0.031, 0},
                              {0.0312, 0.02},
                              {0.033, 0.04},
                              {0.0395, 0.06},
                              {0.0396, 0.08},
                              {0, 0.08}}};
  const double exact = solvers::families::turned_volume(shape.profile);
  for (const double size : {0.02, 0.028}) {
    const auto body = mesh_of(shape, 4, size);
    EXPECT_EQ(body.quality.straightened, 0);
    EXPECT_NEAR(body.quality.volume / exact, 1, 2e-6) << size;
  }
}

TEST(Turned, AHollowBallHasTwoSurfaces) {
  GeneratedShape shape{"turned", {}, {}};
  for (int i = 0; i <= 60; ++i) {
    const double a = -pi / 2 + pi * i / 60;
    shape.profile.push_back({0.03 * std::cos(a), 0.03 * std::sin(a)});
  }
  for (int i = 60; i >= 0; --i) {
    const double a = -pi / 2 + pi * i / 60;
    shape.profile.push_back({0.025 * std::cos(a), 0.025 * std::sin(a)});
  }
  const auto result = mesh_of(shape, 2);
  EXPECT_EQ(mesh_faults(result.mesh), "");
  EXPECT_EQ(boundary_euler_number(result.mesh), 4);
  EXPECT_NEAR(result.quality.volume, 4 * pi / 3 * (2.7e-5 - 1.5625e-5), 0.01 * 4.8e-5);
}

TEST(Turned, BadProfilesAreRefused) {
  const auto refused = [](std::vector<std::array<double, 2>> profile, const std::string& word) {
    const auto message = message_of<core::Error>([&] {
      find_family("turned").check({"turned", {}, std::move(profile)});
    });
    EXPECT_NE(message.find(word), std::string::npos) << message;
  };
  refused({}, "at least three");
  refused({{0, 0}, {1, 0}}, "at least three");
  refused({{-0.1, 0}, {1, 0}, {1, 1}}, "left of the axis");
  refused({{1, 0}, {2, 1}, {2, 0}, {1, 1}}, "crosses");
  refused({{0, 0}, {1, 0.5}, {1, -0.5}}, "single point");
  refused({{1, 0}, {2, 0}, {3, 0}}, "");
  refused({{0, 0}, {1, std::nan("")}, {0, 1}}, "not finite");
}

}  // namespace
}  // namespace carillon::test
