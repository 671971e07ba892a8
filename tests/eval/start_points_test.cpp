#include "eval/material/start_points.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.hpp"
#include "tests/eval/struck_bodies.hpp"

namespace carillon::eval {
namespace {

TEST(EigenvaluesDampedBy, OfAMonotoneModelAreOne) {
  const auto c = [](double lambda) { return 0.3 * std::pow(lambda, 0.4); };
  const auto roots = material::eigenvalues_damped_by(c, 25, 1e4, 1e10);
  ASSERT_EQ(roots.size(), 1U);
  EXPECT_NEAR(roots[0] / std::pow(25 / 0.3, 2.5), 1, 1e-9);
  EXPECT_TRUE(material::eigenvalues_damped_by(c, 1e6, 1e4, 1e10).empty());
}

TEST(EigenvaluesDampedBy, OfASeriesAreAll) {
  // (x - 1)(x - 20)(x - 300) + 50 with x = lambda / 1e6.
  const auto c = [](double lambda) {
    const double x = 1e-6 * lambda;
    return 1e-3 * (x - 1) * (x - 20) * (x - 300) + 50;
  };
  const auto roots = material::eigenvalues_damped_by(c, 50, 1e4, 1e10);
  ASSERT_EQ(roots.size(), 3U);
  EXPECT_NEAR(roots[0], 1e6, 1);
  EXPECT_NEAR(roots[1], 2e7, 10);
  EXPECT_NEAR(roots[2], 3e8, 100);
}

TEST(EigenvaluesDampedBy, PassesOverWhatIsNoNumber) {
  const auto c = [](double lambda) { return std::log(lambda - 1e6); };
  const auto roots = material::eigenvalues_damped_by(c, 15, 1e4, 1e10);
  ASSERT_EQ(roots.size(), 1U);
  EXPECT_NEAR(roots[0], 1e6 + std::exp(15.0), 1);
}

struct Case {
  material::StruckModes modes = test::hinged_plate(2.5e7, 0.2, 0.15, 0.004, 60);
  material::Candidate truth;
  test::Recorded recorded;
  material::Reference reference;
  Case() {
    truth.specific_modulus = 1.3e7;
    truth.scale = 0.2;
    truth.damping = synth::damping::rayleigh_damping(6, 1e-7);
    recorded = test::record(
        material::heard_candidate(modes, truth, material::HeardMotion::velocity, 20, 20000).tones,
        {.seconds = 0.3});
    reference = material::make_reference(recorded.samples, recorded.set);
  }
};

TEST(DampingStarts, AreOneFitForEverySample) {
  const Case c;
  const damping::DampingLaw law;
  const material::MatchScale scale;
  const auto models = material::damping_starts(c.recorded.set.features, law, scale, {});
  ASSERT_EQ(models.size(), material::StartOptions{}.samples);
  for (const auto& model : models) {
    EXPECT_NEAR(model.parameters[0], 6, 1e-3);
    EXPECT_NEAR(model.parameters[1], 1e-7, 1e-11);
  }
  // With scatter, samples differ; a seed gives the same again, another others.
  auto features = c.recorded.set.features;
  for (std::size_t i = 0; i < features.size(); i += 2) features[i].decay_rate *= 1.3;
  const auto scattered = material::damping_starts(features, law, scale, {});
  const auto again = material::damping_starts(features, law, scale, {});
  const auto others = material::damping_starts(features, law, scale, {.seed = 2});
  EXPECT_NE(scattered[1].parameters, scattered[2].parameters);
  EXPECT_EQ(scattered[3].parameters, again[3].parameters);
  EXPECT_NE(scattered[3].parameters, others[3].parameters);
}

TEST(DampingStarts, NeedAsManyFeaturesAsParameters) {
  const Case c;
  const std::span<const features::Feature> one(c.recorded.set.features.data(), 1);
  try {
    material::damping_starts(one, {}, {}, {});
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(error.message().find("1 feature of the recording"), std::string::npos)
        << error.what();
  }
}

TEST(StartPoints, HoldTheTruthWhereNothingIsMissing) {
  const Case c;
  const auto damping = material::damping_starts(c.recorded.set.features, {}, {}, {});
  const auto starts = material::start_points(c.recorded.set.features, c.modes, damping, 0,
                                             material::HeardMotion::velocity, c.reference, {});
  ASSERT_GT(starts.size(), 100U);
  EXPECT_NEAR(starts[0].candidate.specific_modulus / 1.3e7, 1, 1e-3);
  EXPECT_NEAR(starts[0].candidate.scale / 0.2, 1, 0.01);
  EXPECT_GT(starts[0].match, 0.99);
  for (std::size_t i = 1; i < starts.size(); ++i) {
    ASSERT_LE(starts[i].match, starts[i - 1].match);
    ASSERT_GE(starts[i].candidate.specific_modulus, material::StartOptions{}.min_modulus);
    ASSERT_LE(starts[i].candidate.specific_modulus, material::StartOptions{}.max_modulus);
  }
}

}  // namespace
}  // namespace carillon::eval
