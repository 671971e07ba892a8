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
      {.height = height});
}

/// The profile of a drawing.
solvers::families::ProfilePolygon drawn(const std::string& elements,
                                        const solvers::families::SvgProfileOptions& options = {},
                                        const std::string& attributes = "") {
  const core::TemporaryFolder folder;
  return solvers::families::profile_from_svg(
      written(folder, "drawing.svg",
              "<?xml version='1.0'?><svg xmlns='http://www.w3.org/2000/svg' "
              "xmlns:xlink='http://www.w3.org/1999/xlink' " +
                  attributes + ">" + elements + "</svg>"),
      options);
}

double area_drawn(const std::string& elements,
                  const solvers::families::SvgProfileOptions& options = {.height = 1,
                                                                         .axis = "x=0"}) {
  return solvers::families::polygon_area(drawn(elements, options));
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

TEST(SvgProfile, EveryShapeOfADrawing) {
  // Areas over the square of the height.
  EXPECT_NEAR(area_drawn("<rect x='2' y='3' width='4' height='8'/>"), 0.5, 1e-12);
  EXPECT_NEAR(area_drawn("<circle cx='7' cy='5' r='4'/>"), pi / 4, 3e-4);
  EXPECT_NEAR(area_drawn("<ellipse cx='7' cy='5' rx='2' ry='4'/>"), pi / 8, 3e-4);
  EXPECT_NEAR(area_drawn("<polygon points='1,0 7,0 7,12'/>"), 0.25, 1e-12);
  EXPECT_NEAR(area_drawn("<polyline points='1 0 7 0 7 12'/>"), 0.25, 1e-12);
  EXPECT_NEAR(area_drawn("<rect width='10' height='20' rx='2'/>"), (200 - (4 - pi) * 4) / 400,
              3e-4);
}

TEST(SvgProfile, DrawingsAsEditorsWriteThem) {
  // Half as wide as tall.
  for (const std::string& elements :
       {std::string(
            "<defs><path d='M0 0H9V9z'/></defs><g id='layer1' "
            "transform='translate(-30,-40) scale(2 3)'><g transform='matrix(.5 0 0 .5 0 0)'>"
            "<path style='fill:none' d='m 30 80 h 7.5 v 10 h -7.5 z'/></g></g>"),
        std::string("<path transform='rotate(90)' d='M0 0 H10 V-5 H0 z'/>"),
        std::string("<symbol id='s'><rect width='5' height='10'/></symbol><use href='#s' x='3'/>"),
        std::string("<g display='none'><rect width='9' height='9'/></g><rect id='r' width='5' "
                    "height='10'/><path d='M1 1 H9'/>"),
        std::string("<g><!-- <path d='M9 9'/> --><a><switch><rect width='5mm' height='10mm'/>"
                    "</switch></a></g><text>glass</text>"),
        std::string("<clipPath><rect width='3' height='3'/></clipPath><rect id='a' width='5' "
                    "height='10' style='display : inline'/>")}) {
    EXPECT_NEAR(area_drawn(elements), 0.5, 1e-9) << elements;
  }
}

TEST(SvgProfile, SizeOnPaper) {
  const std::string rect = "<rect width='20' height='40'/>";
  const auto tall = [&](const std::string& attributes) {
    double top = 0;
    for (const auto& p : drawn(rect, {}, attributes)) top = std::max(top, p[1]);
    return top;
  };
  EXPECT_NEAR(tall("width='210mm' height='297mm' viewBox='0 0 210 297'"), 0.04, 1e-12);
  EXPECT_NEAR(tall("width='10cm' height='5cm' viewBox='0 0 1000 500'"), 0.004, 1e-12);
  EXPECT_NEAR(tall("width='1in' height='1in'"), 40 * 0.0254 / 96, 1e-12);
  for (const char* none : {"", "width='100' height='50'", "width='100%'", "width='90px'"})
    EXPECT_NE(message_of<core::InputError>([&] { drawn(rect, {}, none); }).find("no size on paper"),
              std::string::npos)
        << none;
}

TEST(SvgProfile, TheAxisIsWhereItIsSaidToBe) {
  const std::string rect = "<rect x='30' y='0' width='5' height='10'/>";
  const auto widest = [&](const std::string& axis) {
    double low = 1e9, high = 0;
    for (const auto& p : drawn(rect, {.height = 10, .axis = axis})) {
      low = std::min(low, p[0]);
      high = std::max(high, p[0]);
    }
    return std::pair(low, high);
  };
  EXPECT_NEAR(widest("x=0").first, 30, 1e-12);
  EXPECT_EQ(widest("left").first, 0);
  EXPECT_NEAR(widest("left").second, 5, 1e-12);
  EXPECT_EQ(widest("right").first, 0);
  EXPECT_NEAR(widest("x=40").first, 5, 1e-12);  // drawn on the left of it
  EXPECT_NEAR(widest("x=40").second, 10, 1e-12);
  const std::string unsaid = message_of<core::InputError>([&] { widest(""); });
  EXPECT_NE(unsaid.find("from x = 30 to 35, and its axis is not given"), std::string::npos)
      << unsaid;
  EXPECT_NE(message_of<core::InputError>([&] { widest("x=32"); }).find("across the axis"),
            std::string::npos);
  EXPECT_NE(message_of<core::InputError>([&] { widest("middle"); }).find("is no axis"),
            std::string::npos);
}

TEST(SvgProfile, SeveralOutlinesAskForAName) {
  const std::string two =
      "<rect id='page' width='50' height='50'/><rect id='cup' width='5' height='10'/>";
  const std::string message = message_of<core::InputError>([&] { area_drawn(two); });
  EXPECT_NE(message.find("rect \"page\", rect \"cup\""), std::string::npos) << message;
  EXPECT_NEAR(area_drawn(two, {.height = 1, .axis = "x=0", .id = "cup"}), 0.5, 1e-12);
  EXPECT_NE(message_of<core::InputError>([&] {
              area_drawn(two, {.height = 1, .id = "mug"});
            }).find("page, cup"),
            std::string::npos);
}

TEST(SvgProfile, WhatCannotBeTurnedIsRefused) {
  const auto reason = [](const std::string& data) {
    return message_of<core::InputError>([&] { profile_of(data, 0.1); });
  };
  EXPECT_NE(reason("M-10 0 H10 V10 H-10 Z").find("across the axis"), std::string::npos);
  EXPECT_NE(reason("M0 0 L10 10 L10 0 L0 10 Z").find("crosses"), std::string::npos);
  EXPECT_NE(reason("M0 0 L10 0 L10 10 Z M1 1 L2 2").find("one outline"), std::string::npos);
  EXPECT_NE(reason("M0 0 L10 banana").find("character 10"), std::string::npos);
  EXPECT_NE(reason("L10 10").find("M, which begins"), std::string::npos);
  EXPECT_NE(reason("").find("no outline"), std::string::npos);
  EXPECT_NE(reason("M0 0 A10 10 0 2 0 1 1").find("flag"), std::string::npos);
  EXPECT_NE(reason("M0 0 H10 H0 Z").find("no outline"), std::string::npos);
  EXPECT_NE(reason("M0 0 A1e200 1e200 0 0 0 10 10 V20 H0 Z").find("squared"), std::string::npos);
  EXPECT_NE(reason("M0 0 C1e30 0 1e30 10 0 10 Z").find("10000 points"), std::string::npos);
  const core::TemporaryFolder folder;
  for (const char* drawing :
       {"<svg><rect/></svg>", "<svg/>", "<html/>", "", "<svg", "<svg><path",
        "<svg><rect width='1' height='2' transform='turn(3)'/></svg>",
        "<svg><rect width='1em' height='2'/></svg>", "<svg><g id='a'><use href='#a'/></g></svg>"})
    EXPECT_THROW(
        solvers::families::profile_from_svg(written(folder, "n.svg", drawing), {.height = 1}),
        core::InputError)
        << drawing;
  EXPECT_NE(message_of<core::InputError>([&] {
              drawn("<g><rect id='a' width='1em' height='2'/></g>", {.height = 1});
            }).find("the drawing's rect \"a\": \"1em\" is no length"),
            std::string::npos);
  EXPECT_THROW(solvers::families::profile_from_svg(folder.path() / "missing.svg", {.height = 1}),
               core::FileError);
}

TEST(SvgProfile, ABoreThatMayBeASlipIsTold) {
  const auto warning = [](double inner) {
    return solvers::families::bore_warning(
        {"turned", {}, {{inner, 0}, {0.03, 0}, {0.03, 0.1}, {inner, 0.1}}});
  };
  EXPECT_EQ(warning(0), "");
  EXPECT_NE(warning(0.0002).find("a bore of 0.4 mm"), std::string::npos) << warning(0.0002);
  EXPECT_EQ(warning(0.01), "");
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
      EXPECT_GE(solvers::families::profile_from_svg(file, {.height = 0.1}).size(), 3u);
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
