#include "eval/material/match_ratio.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>

namespace carillon::eval {
namespace {

features::Feature feature(double frequency, double decay_rate, double amplitude) {
  features::Feature one;
  one.frequency = frequency;
  one.decay_rate = decay_rate;
  one.amplitude = amplitude;
  return one;
}

std::vector<features::Feature> any_features() {
  const auto count = *rc::gen::inRange(1, 20);
  std::vector<features::Feature> features;
  for (int i = 0; i < count; ++i) {
    features.push_back(feature(*rc::gen::inRange(30, 18000), 0.1 * *rc::gen::inRange(1, 3000),
                               0.001 * *rc::gen::inRange(1, 1000)));
  }
  return features;
}

double product(const std::vector<features::Feature>& a, const std::vector<features::Feature>& b) {
  const material::MatchScale scale;
  const auto first = material::places_of(a, scale);
  const auto second = material::places_of(b, scale);
  return material::match_ratio(first, second, scale) * material::match_ratio(second, first, scale);
}

TEST(MatchRatio, OfEqualSetsIsOne) {
  const bool holds = rc::check("R(f, f) = 1", [] {
    const auto features = any_features();
    RC_ASSERT(std::abs(product(features, features) - 1) < 1e-12);
  });
  EXPECT_TRUE(holds);
}

TEST(MatchRatio, OfEmptySetsIsNothing) {
  EXPECT_EQ(product({}, {feature(400, 3, 1)}), 0);
  EXPECT_EQ(product({feature(400, 3, 1)}, {}), 0);
}

TEST(MatchRatio, IsSymmetricAsAProductAndWithinOne) {
  const bool holds = rc::check("R(a, b) R(b, a)", [] {
    const auto a = any_features();
    const auto b = any_features();
    const double value = product(a, b);
    RC_ASSERT(std::abs(value - product(b, a)) < 1e-12);
    RC_ASSERT(value > 0 && value <= 1);
  });
  EXPECT_TRUE(holds);
}

TEST(MatchRatio, FollowsTheEquations) {
  // Two features against one, every term of eq. 3.6 and 3.7 by hand. 1000 Hz is 8.5109 Bark, 1010
  // Hz is 8.5715 Bark by Zwicker and Terhardt's formula.
  const material::MatchScale scale;
  const auto bark = [](double f) {
    return 13 * std::atan(0.00076 * f) + 3.5 * std::atan(std::pow(f / 7500, 2));
  };
  const double distance = (bark(1010) - bark(1000)) / 0.1;
  const double longer = (std::log(1.0 / 5 + 2e-3) - std::log(1.0 / 8 + 2e-3)) / 0.3;
  const double louder = 20 * std::log10(2.0) / 10;
  const double k = 1 / ((1 + distance * distance) * (1 + longer * longer) * (1 + louder * louder));
  const auto one = material::places_of(std::vector{feature(1000, 8, 0.5)}, scale);
  const auto other = material::places_of(std::vector{feature(1010, 5, 1)}, scale);
  EXPECT_NEAR(material::similarity(one[0], other[0], scale), k, 1e-12);
  EXPECT_NEAR(material::match_ratio(one, other, scale), k, 1e-12);

  auto two = one;
  two.push_back(one[0]);
  two[1].bark += 5;
  two[0].prominence = 3;
  two[1].prominence = 1;
  const double far = material::similarity(two[1], other[0], scale);
  EXPECT_LT(far, 1e-3);
  EXPECT_NEAR(material::match_ratio(two, other, scale), (3 * k + far) / 4, 1e-12);
  EXPECT_NEAR(material::match_ratio(other, two, scale), k, 1e-12);
}

TEST(MatchRatio, FallsWithEveryMismatch) {
  const std::vector<features::Feature> truth = {feature(300, 4, 1), feature(1400, 9, 0.5),
                                                feature(5000, 30, 0.2)};
  const auto shifted = [&](double frequency, double decay, double level) {
    auto other = truth;
    for (features::Feature& one : other) {
      one.frequency *= frequency;
      one.decay_rate *= decay;
      one.amplitude *= level;
    }
    return product(truth, other);
  };
  for (double last = 1, step = 1.001; step < 1.03; step *= 1.003) {
    EXPECT_LT(shifted(step, 1, 1), last) << step;
    last = shifted(step, 1, 1);
  }
  for (double last = 1, step = 1.05; step < 10; step *= 1.2) {
    EXPECT_LT(shifted(1, step, 1), last) << step;
    last = shifted(1, step, 1);
  }
  for (double last = 1, step = 1.05; step < 100; step *= 1.2) {
    EXPECT_LT(shifted(1, 1, step), last) << step;
    last = shifted(1, 1, step);
  }
}

TEST(MatchRatio, DoesNotCompareARoomsDuration) {
  std::vector<features::Feature> dry = {feature(600, 40, 1)};
  std::vector<features::Feature> wet = {feature(600, 8, 1)};
  EXPECT_LT(product(dry, wet), 0.2);
  wet[0].reverberant = true;
  EXPECT_NEAR(product(dry, wet), 1, 1e-12);
}

TEST(MatchRatio, FallsWithEveryFeatureMissing) {
  std::vector<features::Feature> truth;
  for (int i = 1; i <= 8; ++i) truth.push_back(feature(300 * i, 3 * i, 1.0 / i));
  auto fewer = truth;
  double last = 1;
  while (fewer.size() > 1) {
    fewer.pop_back();
    EXPECT_LT(product(truth, fewer), last);
    last = product(truth, fewer);
  }
}

TEST(MatchRatio, WeighsProminenceWithoutRegardToGain) {
  std::vector<features::Feature> features = {feature(500, 5, 1), feature(2500, 20, 0.01),
                                             feature(9000, 100, 0.3)};
  const auto places = material::places_of(features, {});
  for (features::Feature& one : features) one.amplitude *= 1e-5;
  const auto quiet = material::places_of(features, {});
  for (std::size_t i = 0; i < places.size(); ++i) {
    EXPECT_NEAR(places[i].prominence, quiet[i].prominence, 1e-12);
  }
  // What is beyond the range of levels does not count.
  material::MatchScale narrow;
  narrow.range = 20;
  EXPECT_EQ(material::places_of(features, narrow)[1].prominence, 0);
}

}  // namespace
}  // namespace carillon::eval
