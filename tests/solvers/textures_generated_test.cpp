#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "core/error.hpp"
#include "render/maps/generated_maps.hpp"

namespace carillon::solvers {
namespace {

float at(const render::maps::SurfaceMap& map, int column, int row) {
  return map.heights[std::size_t(row) * std::size_t(map.width) + std::size_t(column)];
}

std::string hint_of(const std::string& name, const std::map<std::string, double>& parameters,
                    int texels = 256) {
  try {
    render::maps::generate_map(name, parameters, texels, 0);
  } catch (const core::InputError& error) {
    return error.what();
  }
  return "nothing thrown";
}

TEST(GeneratedMaps, AreReliefsFromZeroDownWithoutASeam) {
  for (const auto& generated : render::maps::generated_maps()) {
    for (const int texels : {120, 128, 256}) {
      const render::maps::SurfaceMap map =
          render::maps::generate_map(generated.name, {}, texels, 7);
      EXPECT_EQ(map.name, generated.name);
      EXPECT_TRUE(map.repeats);
      EXPECT_LE(std::max(map.width, map.height), texels);
      EXPECT_GE(std::max(map.width, map.height), texels - 16);
      EXPECT_EQ(*std::max_element(map.heights.begin(), map.heights.end()), 0);
      EXPECT_LT(*std::min_element(map.heights.begin(), map.heights.end()), 0);
      // Steps across the seam are like those elsewhere.
      double seam = 0, inner = 0;
      for (int j = 0; j < map.height; ++j) {
        seam = std::max(seam, std::abs(double(at(map, 0, j)) - at(map, map.width - 1, j)));
        for (int i = 1; i < map.width; ++i) {
          inner = std::max(inner, std::abs(double(at(map, i, j)) - at(map, i - 1, j)));
        }
      }
      for (int i = 0; i < map.width; ++i) {
        seam = std::max(seam, std::abs(double(at(map, i, 0)) - at(map, i, map.height - 1)));
        for (int j = 1; j < map.height; ++j) {
          inner = std::max(inner, std::abs(double(at(map, i, j)) - at(map, i, j - 1)));
        }
      }
      EXPECT_LE(seam, inner * 1.2) << generated.name << texels;
      EXPECT_EQ(render::maps::generate_map(generated.name, {}, texels, 7).heights, map.heights);
      const bool drawn = generated.name != "grooves" && generated.name != "tiles";
      EXPECT_EQ(render::maps::generate_map(generated.name, {}, texels, 8).heights != map.heights,
                drawn);
    }
  }
}

TEST(GeneratedMaps, GroovesHaveExactlyTheirWavelengthAndDepth) {
  for (const int texels : {64, 500, 512, 1000}) {
    const render::maps::SurfaceMap map = render::maps::generate_map(
        "grooves", {{"wavelength", 0.0037}, {"depth", 0.0011}, {"waves", 7}}, texels, 0);
    const int per_wave = texels / 7;
    EXPECT_EQ(map.width, 7 * per_wave);
    EXPECT_DOUBLE_EQ(map.texel * per_wave, 0.0037);
    for (int i = 0; i < map.width; ++i) {
      const double u = (i + 0.5) * map.texel;
      // Valleys at whole wavelengths; the highest texel may lie beside the ridge.
      const double expected = -0.0011 / 2 * (1 + std::cos(2 * std::numbers::pi * u / 0.0037));
      const double shift =
          per_wave % 2 == 1 ? 0 : 0.0011 / 2 * (1 - std::cos(std::numbers::pi / per_wave));
      EXPECT_NEAR(at(map, i, 5), expected + shift, 1e-9);
    }
  }
}

TEST(GeneratedMaps, RoundGroovesAreArcs) {
  const render::maps::SurfaceMap map = render::maps::generate_map(
      "grooves", {{"wavelength", 0.01}, {"depth", 0.002}, {"waves", 1}, {"round", 1}}, 129, 0);
  const double radius = (0.005 * 0.005 + 0.002 * 0.002) / 0.004;
  for (int i = 0; i < map.width; ++i) {
    const double off = (i + 0.5) * map.texel - 0.005;
    EXPECT_NEAR(std::hypot(off, at(map, i, 0) + radius), radius, 1e-8);
  }
}

TEST(GeneratedMaps, BrickHasItsJointsWhereTheyAreAskedFor) {
  const render::maps::SurfaceMap map = render::maps::generate_map(
      "brick", {{"unevenness", 0}, {"rounding", 0.002}, {"columns", 2}, {"rows", 4}}, 900, 0);
  ASSERT_EQ(map.width, 900);   // 0.45 m
  ASSERT_EQ(map.height, 600);  // 0.30 m
  EXPECT_DOUBLE_EQ(map.texel, 0.0005);
  // Along a row of bricks: 215 mm of brick, 10 mm of mortar; every second row half a brick on.
  for (const int row : {0, 1, 2, 3}) {
    const int j = 75 + 150 * row;  // the middle of a row
    for (int i = 0; i < 900; ++i) {
      const double u = (i + 0.5) * 0.0005 + (row % 2) * 0.1125;
      const double in_brick = std::fmod(u, 0.225) - 0.005;  // from its left edge
      const double inside = std::min(in_brick, 0.215 - in_brick);
      const double expected = inside < 0 ? -0.004
                              : inside > 0.002
                                  ? 0
                                  : std::sqrt(4e-6 - (0.002 - inside) * (0.002 - inside)) - 0.002;
      EXPECT_NEAR(at(map, i, j), expected, 1e-6) << row << " " << i;
    }
  }
  for (int j = 0; j < 600; ++j) {
    const double in_brick = std::fmod((j + 0.5) * 0.0005, 0.075) - 0.005;
    EXPECT_EQ(at(map, 100, j) == -0.004F, in_brick < 0 || in_brick > 0.065) << j;
  }
}

// Power spectral density of the profiles along u: its slope in double logarithms.
TEST(GeneratedMaps, NoiseHasItsExponentAndRms) {
  for (const double exponent : {1.0, 2.5, 4.0}) {
    const int n = 256;
    const render::maps::SurfaceMap map = render::maps::generate_map(
        "noise", {{"exponent", exponent}, {"rms", 0.0003}, {"length", 0.2}, {"longest", 0.2}}, n,
        5);
    double mean = 0, square = 0;
    for (const float height : map.heights) mean += height / double(n * n);
    for (const float height : map.heights) square += std::pow(height - mean, 2) / double(n * n);
    EXPECT_NEAR(std::sqrt(square), 0.0003, 1e-8);
    double sx = 0, sy = 0, sxx = 0, sxy = 0, count = 0;
    for (int k = 4; k <= 32; ++k) {
      double power = 0;
      for (int row = 0; row < n; ++row) {
        std::complex<double> wave = 0;
        for (int i = 0; i < n; ++i) {
          wave += double(at(map, i, row)) * std::polar(1.0, -2 * std::numbers::pi * k * i / n);
        }
        power += std::norm(wave);
      }
      const double x = std::log(k), y = std::log(power);
      sx += x, sy += y, sxx += x * x, sxy += x * y, count += 1;
    }
    EXPECT_NEAR((count * sxy - sx * sy) / (count * sxx - sx * sx), -exponent, 0.35);
  }
}

TEST(GeneratedMaps, MoreTexelsAreTheSameSurfaceFiner) {
  for (const char* name : {"noise", "pebbles"}) {
    std::map<std::string, double> coarse_waves;
    if (std::string(name) == "noise") coarse_waves["shortest"] = 0.01;
    const render::maps::SurfaceMap coarse = render::maps::generate_map(name, coarse_waves, 128, 2);
    const render::maps::SurfaceMap fine = render::maps::generate_map(name, coarse_waves, 256, 2);
    const double depth = -*std::min_element(fine.heights.begin(), fine.heights.end());
    double square = 0;
    for (int k = 0; k < 500; ++k) {
      const Eigen::Vector2d uv(0.00017 * k, 0.00013 * k);
      square +=
          std::pow(render::maps::height_at(coarse, uv) - render::maps::height_at(fine, uv), 2) /
          500;
    }
    EXPECT_LT(std::sqrt(square), 0.04 * depth) << name;
  }
}

TEST(GeneratedMaps, RefuseWithTheNearestNameAndARemedy) {
  const auto has = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_TRUE(has(hint_of("bricks", {}), "did you mean \"brick\"?"));
  EXPECT_TRUE(has(hint_of("brick", {{"morter", 1}}), "did you mean \"mortar\"?"));
  EXPECT_TRUE(has(hint_of("brick", {}, 15), "16 to 4096"));
  EXPECT_TRUE(has(hint_of("brick", {}, 5000), "16 to 4096"));
  EXPECT_TRUE(has(hint_of("brick", {}, 32), "more texels"));
  EXPECT_TRUE(has(hint_of("brick", {{"rows", 3}}), "even number"));
  EXPECT_TRUE(has(hint_of("brick", {{"rows", 2.5}}), "whole number"));
  EXPECT_TRUE(has(hint_of("brick", {{"rounding", 0.04}}), "half a block"));
  EXPECT_TRUE(has(hint_of("brick", {{"mortar", -0.01}}), "mortar must be positive"));
  EXPECT_TRUE(has(hint_of("tiles", {{"unevenness", -1}}), "must not be negative"));
  EXPECT_TRUE(has(hint_of("noise", {{"rms", NAN}}), "rms must be positive"));
  EXPECT_TRUE(has(hint_of("noise", {{"longest", 1}}), "does not repeat"));
  EXPECT_TRUE(has(hint_of("noise", {{"longest", 0.031}, {"shortest", 0.0309}}), "more room"));
  EXPECT_TRUE(has(hint_of("noise", {{"shortest", 0.07}}), "longer than the longest"));
  EXPECT_TRUE(has(hint_of("grooves", {{"waves", 100}}), "4 texels"));
  EXPECT_TRUE(has(hint_of("grooves", {{"round", 2}}), "0 for a sine"));
  EXPECT_TRUE(has(hint_of("grooves", {{"round", 1}, {"depth", 0.0011}}), "half a wavelength"));
  EXPECT_TRUE(has(hint_of("pebbles", {{"columns", 2}}), "at least 3"));
  EXPECT_TRUE(has(hint_of("pebbles", {{"irregularity", 2}}), "0 to 1"));
}

}  // namespace
}  // namespace carillon::solvers
