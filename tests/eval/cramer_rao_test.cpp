#include "eval/features/cramer_rao.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "tests/eval/strike_clip.hpp"

namespace carillon::eval {
namespace {

features::Feature mode(double frequency, double decay_rate, double amplitude, double phase) {
  features::Feature feature;
  feature.frequency = frequency;
  feature.decay_rate = decay_rate;
  feature.amplitude = amplitude;
  feature.phase = phase;
  return feature;
}

/// Of one mode that is seen until it is gone: the variance of omega and of d is
/// 16 d^3 sigma^2 / (a^2 rate), by integrals of t^n exp(-2 d t).
TEST(CramerRao, OfOneModeIsTheClosedForm) {
  constexpr double rate = 44100, noise = 0.1;
  for (const double d : {5., 20., 80.}) {
    const std::vector<features::Feature> one = {mode(2345, d, 0.7, 1.1)};
    const features::ModeBound bound = features::cramer_rao(one, {rate, 0, 10 / d, noise})[0];
    const double expected = 4 * noise * std::pow(d, 1.5) / (0.7 * std::sqrt(rate));
    EXPECT_NEAR(bound.decay_rate / expected, 1, 0.01) << d;
    EXPECT_NEAR(2 * std::numbers::pi * bound.frequency / expected, 1, 0.01) << d;
  }
}

TEST(CramerRao, OfNeighboursIsThatOfAnotherProgram) {
  const std::vector<features::Feature> modes = {mode(1000, 12, 1, 0.3), mode(1003, 20, 0.5, 2),
                                                mode(5000, 40, 0.2, 4)};
  std::vector<Partial> partials;
  for (const features::Feature& m : modes)
    partials.push_back({m.frequency, m.decay_rate, m.amplitude, m.phase});
  const std::vector<features::ModeBound> bounds =
      features::cramer_rao(modes, {44100, 0.003, 1, 0.02});
  const auto others = cramer_rao(partials, ClipShape{44100, 1, 0}, 0.003, 0.02);
  for (std::size_t i = 0; i < modes.size(); ++i) {
    EXPECT_NEAR(bounds[i].frequency / others[i].frequency, 1, 1e-6);
    EXPECT_NEAR(bounds[i].decay_rate / others[i].decay_rate, 1, 1e-6);
  }
  // A neighbour within the line's width makes both harder to know.
  const features::ModeBound alone =
      features::cramer_rao(std::vector{modes[0]}, {44100, 0.003, 1, 0.02})[0];
  EXPECT_GT(bounds[0].frequency, 1.5 * alone.frequency);
}

TEST(CramerRao, WhatCannotBeKnownIsRefused) {
  const std::vector<features::Feature> twins = {mode(1000, 10, 1, 0), mode(1000, 10, 1, 0)};
  EXPECT_THROW(features::cramer_rao(twins, {44100, 0, 1, 0.1}), core::InputError);
  EXPECT_THROW(features::cramer_rao(std::vector{twins[0]}, {44100, 0, 1, 0}), core::InputError);
  EXPECT_THROW(features::cramer_rao(std::vector{twins[0]}, {44100, 1, 1, 0.1}), core::InputError);
}

}  // namespace
}  // namespace carillon::eval
