#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "core/error.hpp"
#include "core/temporary_folder.hpp"
#include "solvers/families/detail/svg_path.hpp"
#include "solvers/families/families.hpp"
#include "solvers/families/outline.hpp"
#include "tests/solvers/written_files.hpp"

namespace carillon::test {
namespace {

using namespace solvers;
constexpr double pi = std::numbers::pi;

solvers::families::ProfilePolygon profile_of(const std::string& path_data, double height) {
  const core::TemporaryFolder folder;
  return solvers::families::profile_from_svg(
      written(folder, "profile.svg",
              "<svg xmlns=\"http://www.w3.org/2000/svg\"><path d=\"" + path_data + "\"/></svg>"),
      height);
}

/// End of the last curve, before the line that closes the outline.
std::array<double, 2> end_of(const std::string& data) {
  return solvers::families::parse_svg_path(data).back().points[0];
}

TEST(SvgProfile, HeightPointsUpAndIsScaled) {
  // A trapezium 20 wide at the top of the drawing, 10 at its foot, 40 tall.
  const auto profile = profile_of("M0,10 L20,10 L10,50 L0,50 Z", 0.08);
  ASSERT_EQ(profile.size(), 4u);
  EXPECT_NEAR(solvers::families::polygon_area(profile), 15 * 40 * 0.002 * 0.002, 1e-15);
  double top_radius = 0;
  for (const auto& p : profile) {
    EXPECT_GE(p[1], 0);
    if (p[1] > 0.0799) top_radius = std::max(top_radius, p[0]);
  }
  EXPECT_NEAR(top_radius, 0.04, 1e-15);
}

TEST(SvgProfile, EveryCommandSaysTheSame) {
  const auto plain = profile_of("M 0 0 L 30 0 L 30 40 L 10 40 L 10 60 L 0 60 Z", 0.06);
  for (const char* same :
       {"M0 0H30V40H10V60H0Z", "m0 0h30v40h-20v20h-10z", "M0,0 30,0 30,40 10,40 10,60 0,60",
        "m 0 0 30 0 0 40 -20 0 0 20 -10 0 z", "M0 0 C10 0 20 0 30 0 Q30 20 30 40 L10 40 V60 H0 z",
        "M+0-0L3e1,0L30 4.0e+1L10 40L10 60L0 60Z"}) {
    const auto profile = profile_of(same, 0.06);
    EXPECT_NEAR(solvers::families::polygon_area(profile), solvers::families::polygon_area(plain),
                1e-15)
        << same;
  }
}

TEST(SvgProfile, CurvesAreFlattenedToATenThousandthOfTheHeight) {
  // A half disc of radius 50 by an arc; the same by two cubics is right to 3e-4 of the radius.
  const auto arc = profile_of("M0 0 A50 50 0 0 1 0 100 Z", 0.1);
  EXPECT_NEAR(solvers::families::polygon_area(arc) / (pi / 2 * 0.05 * 0.05), 1, 3e-4);
  for (const auto& p : arc)
    if (p[0] > 0) {
      EXPECT_NEAR(std::hypot(p[0], p[1] - 0.05), 0.05, 1e-6);
    }
  const auto cubic = profile_of("M0 0 C27.6142 0 50 22.3858 50 50 S 27.6142 100 0 100 Z", 0.1);
  EXPECT_NEAR(solvers::families::polygon_area(cubic) / (pi / 2 * 0.05 * 0.05), 1, 6e-4);
  // Under a parabola: two thirds of its box.
  const auto parabola = profile_of("M0 0 Q 40 30 0 60 Z", 0.06);
  EXPECT_NEAR(solvers::families::polygon_area(parabola) / (2.0 / 3 * 0.02 * 0.06), 1, 3e-4);
  // T goes on as the reflected parabola would.
  EXPECT_NEAR(end_of("M0 0 Q10 0 10 10 T20 20")[0], 20, 1e-12);
}

TEST(SvgPath, ArcsFollowTheirFlags) {
  // From (10, 0) to (0, 10) about (0, 0) or (10, 10): the middle of the arc tells which.
  const auto middle = [](const std::string& flags) {
    const auto curves = solvers::families::parse_svg_path("M10 0A10 10 0 " + flags + " 0 10");
    double minimum = 1e9, maximum = 0;
    for (const auto& curve : curves) {
      if (curve.straight) continue;
      for (const auto& p : curve.points) {
        minimum = std::min(minimum, std::min(p[0], p[1]));
        maximum = std::max(maximum, std::max(p[0], p[1]));
      }
    }
    return std::array{minimum, maximum};
  };
  EXPECT_NEAR(middle("0 1")[1], 10, 0.3);   // quarter about the origin
  EXPECT_NEAR(middle("0 0")[0], 0, 0.3);    // quarter about (10, 10)
  EXPECT_NEAR(middle("1 1")[1], 20, 0.3);   // three quarters about (10, 10)
  EXPECT_NEAR(middle("1 0")[0], -10, 0.3);  // three quarters about the origin
  // Flags may run together with the next number; too small radii grow to fit.
  EXPECT_EQ(solvers::families::parse_svg_path("M10 0A10 10 0 010 10").size(),
            solvers::families::parse_svg_path("M10 0A10 10 0 0 1 0 10").size());
  EXPECT_NEAR(end_of("M0 0A1 1 0 0 1 10 0")[0], 10, 1e-12);
}

TEST(SvgProfile, FindsTheFirstPathWhateverStandsAround) {
  const core::TemporaryFolder folder;
  const auto file =
      written(folder, "a.svg",
              "<?xml version='1.0'?><!DOCTYPE svg><!-- <path d=\"M9 9\"/> -->\n"
              "<svg width=\"50%\"><g transform=\"scale(2)\"><rect/></g>\n"
              "<g id='x'><path\n style='fill:none' id=\"pd\" d='M0 0 H10 V10 H0 z' /></g>"
              "<path d='M1 1'/></svg>");
  EXPECT_NEAR(solvers::families::polygon_area(solvers::families::profile_from_svg(file, 0.1)), 0.01,
              1e-15);
}

TEST(SvgProfile, WhatCannotBeTurnedIsRefused) {
  const auto reason = [](const std::string& data) {
    return message_of<core::InputError>([&] { profile_of(data, 0.1); });
  };
  EXPECT_NE(reason("M-10 0 H10 V10 H-10 Z").find("left of the axis"), std::string::npos);
  EXPECT_NE(reason("M0 0 L10 10 L10 0 L0 10 Z").find("crosses"), std::string::npos);
  EXPECT_NE(reason("M0 0 L10 0 L10 10 Z M1 1 L2 2").find("one outline"), std::string::npos);
  EXPECT_NE(reason("M0 0 L10 banana").find("character 10"), std::string::npos);
  EXPECT_NE(reason("L10 10").find("M, which begins"), std::string::npos);
  EXPECT_NE(reason("").find("a path"), std::string::npos);
  EXPECT_NE(reason("M0 0 A10 10 0 2 0 1 1").find("flag"), std::string::npos);
  EXPECT_NE(reason("M0 0 H10 H0 Z").find("no height"), std::string::npos);
  EXPECT_NE(reason("M0 0 A1e200 1e200 0 0 0 10 10 V20 H0 Z").find("squared"), std::string::npos);
  EXPECT_NE(reason("M0 0 C1e30 0 1e30 10 0 10 Z").find("10000 points"), std::string::npos);
  const core::TemporaryFolder folder;
  const auto moved =
      written(folder, "m.svg", "<svg><g transform='scale(2)'><path d='M0 0H1V1H0z'/></g></svg>");
  EXPECT_NE(message_of<core::InputError>([&] {
              solvers::families::profile_from_svg(moved, 1);
            }).find("transform"),
            std::string::npos);
  const auto none = written(folder, "n.svg", "<svg><rect/></svg>");
  EXPECT_NE(message_of<core::InputError>([&] {
              solvers::families::profile_from_svg(none, 1);
            }).find("no path"),
            std::string::npos);
  EXPECT_THROW(solvers::families::profile_from_svg(folder.path() / "missing.svg", 1),
               core::FileError);
  EXPECT_THROW(solvers::families::profile_from_svg(none, 0), core::InputError);
}

TEST(SvgProfile, DamagedFilesEndInAnErrorOrAProfile) {
  const core::TemporaryFolder folder;
  const std::string good =
      "<svg><g><path id='a' d='M0 0 C10 0 20 0 30 0 Q30 20 30 40 A5 5 0 0 1 10 40 V60 H0 z'/>"
      "</g></svg>";
  std::mt19937_64 random(7);
  for (int i = 0; i < 400; ++i) {
    const auto file = written(folder, "damaged.svg", damaged(good, random));
    try {
      EXPECT_GE(solvers::families::profile_from_svg(file, 0.1).size(), 3u);
    } catch (const core::InputError& error) {
      EXPECT_FALSE(error.message().empty());
    }
  }
}

TEST(SvgProfile, AWineGlassBecomesAMesh) {
  // Foot, stem and cup of 2 mm wall, drawn in millimetres.
  solvers::mesh::GeneratedShape shape;
  shape.family = "turned";
  shape.profile = profile_of(
      "M0 160 H32 V157 Q6 155 4 145 V80 C30 75 38 50 32 0 H30 C36 50 28 72 0 76 Z", 0.16);
  solvers::families::find_family("turned").check(shape);
  solvers::mesh::MeshOptions options;
  const auto result = solvers::families::mesh_family(shape, options);
  EXPECT_GT(result.quality.volume, 1e-5);
  EXPECT_LT(result.quality.elements, 10000);
}

}  // namespace
}  // namespace carillon::test
