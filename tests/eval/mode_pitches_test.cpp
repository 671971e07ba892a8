#include "eval/material/mode_pitches.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "eval/material/assumed_material.hpp"
#include "tests/synth/curved_bodies.hpp"

namespace carillon::eval {
namespace {

constexpr double faintest = 0.02;

/// A sphere that breathes, turns about z, and swells at its poles.
solvers::modes::Modes sphere() {
  const std::vector<double> frequencies = {500, 900, 2000};
  std::vector<double> eigenvalues;
  for (const double f : frequencies) eigenvalues.push_back(std::pow(2 * std::numbers::pi * f, 2));
  auto modes = synth::modes_with(synth::curved_sphere(0.1, Vec3::Zero(), 2, 3), eigenvalues,
                                 [](int mode, const Vec3& x) -> Vec3 {
                                   if (mode == 0) return x / 0.1;
                                   if (mode == 1) return {-x.y() / 0.1, x.x() / 0.1, 0};
                                   return x.z() * x / 0.01;
                                 });
  modes.certificate.complete_to_hz = 3000;
  modes.pitch_errors = {1, 2, 3};
  return modes;
}

TEST(ModePitches, AreThoseOfTheModes) {
  const auto pitches = material::mode_pitches(sphere(), 2e7, 0.3, std::nullopt);
  ASSERT_EQ(pitches.frequencies.size(), 3U);
  EXPECT_NEAR(pitches.frequencies[2], 2000, 1e-9);
  EXPECT_EQ(pitches.errors, (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(pitches.complete_to_hz, 3000);
  EXPECT_EQ(pitches.specific_modulus, 2e7);
}

TEST(ModePitches, OfAModeWithoutNormalMotionAreNotHeard) {
  const auto pitches = material::mode_pitches(sphere(), 2e7, 0.3, std::nullopt);
  EXPECT_NEAR(pitches.weights[0], 1, 1e-3);
  EXPECT_LT(pitches.weights[1], 2 * faintest);  // facets are nearly round
  EXPECT_GT(pitches.weights[2], 0.3);
  EXPECT_LT(pitches.weights[2], 0.9);
}

TEST(ModePitches, KnowWhereItWasStruck) {
  const auto modes = sphere();
  const auto weight = [&](const Vec3& at) {
    return material::mode_pitches(modes, 2e7, 0.3, material::unit_strike(modes, at, std::nullopt))
        .weights[2];
  };
  EXPECT_GT(weight({0, 0, 0.1}), 0.7);  // the pole
  EXPECT_LT(weight({0.1, 0, 0}), 0.1);  // the equator is its node
}

TEST(Audibility, FallsWithLevelAndIsSharedByPairs) {
  Eigen::MatrixXd amplitudes(4, 1);
  amplitudes << 1, 0.1, 0.1, 1e-6;
  const std::vector<double> frequencies = {500, 1000, 1001, 3000};
  const auto weights = material::audibility(frequencies, amplitudes);
  EXPECT_DOUBLE_EQ(weights[0], 1);
  EXPECT_NEAR(weights[1], 0.5 * std::pow(10, -20 / 50.0), 1e-12);  // 20 dB down, one of two
  EXPECT_EQ(weights[1], weights[2]);
  EXPECT_DOUBLE_EQ(weights[3], faintest);
}

TEST(ModePitches, BetweenRatiosAreLinearAndKnownWhereBothAre) {
  const material::ModePitches low{0.1, 2e7, {100, 200, 300}, {1, 2, 3}, {1, 1, 1}, 350};
  const material::ModePitches high{0.2, 2e7, {90, 220}, {3, 4}, {0.5, 1}, 340};
  const auto pitches = material::between(low, high, 0.125);
  EXPECT_EQ(pitches.poisson_ratio, 0.125);
  ASSERT_EQ(pitches.frequencies.size(), 2U);
  EXPECT_NEAR(pitches.frequencies[0], 97.5, 1e-12);
  EXPECT_NEAR(pitches.frequencies[1], 205, 1e-12);
  EXPECT_NEAR(pitches.errors[1], 2.5, 1e-12);
  EXPECT_NEAR(pitches.weights[0], 0.875, 1e-12);
  // The third mode is somewhere above.
  EXPECT_NEAR(pitches.complete_to_hz, 205, 1e-12);
}

}  // namespace
}  // namespace carillon::eval
