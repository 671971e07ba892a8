// Recordings and bodies from which no material can be estimated, or hardly.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "eval/material/estimate_material.hpp"
#include "tests/eval/struck_bodies.hpp"

namespace carillon::eval {
namespace {

features::Feature tone(double frequency, double decay_rate, double amplitude) {
  features::Feature feature;
  feature.frequency = frequency;
  feature.decay_rate = decay_rate;
  feature.amplitude = amplitude;
  return feature;
}

std::vector<features::Feature> bar_tones(const synth::damping::DampingModel& damping) {
  material::Candidate candidate;
  candidate.specific_modulus = 2.5e7;
  candidate.scale = 0.1;
  candidate.damping = damping;
  return material::heard_candidate(test::free_bar(2.5e7, 0.3, 0.008, 16), candidate,
                                   material::HeardMotion::velocity, 20, 20000)
      .tones;
}

material::MaterialEstimate estimate(const test::Recorded& recorded,
                                    const material::MaterialOptions& options = {}) {
  return material::estimate_material(recorded.samples, recorded.set,
                                     test::free_bar(1e7, 0.3, 0.008, 16), options);
}

std::string message_of(const test::Recorded& recorded, const material::StruckModes& modes,
                       const material::MaterialOptions& options = {}) {
  try {
    material::estimate_material(recorded.samples, recorded.set, modes, options);
  } catch (const core::InputError& error) {
    return error.message();
  }
  return "";
}

bool remarked(const material::MaterialEstimate& estimate, const std::string& words) {
  return std::any_of(
      estimate.remarks.begin(), estimate.remarks.end(),
      [&](const std::string& remark) { return remark.find(words) != std::string::npos; });
}

void expect_finite(const material::MaterialEstimate& found) {
  EXPECT_TRUE(std::isfinite(found.value.metric));
  EXPECT_GT(found.candidate.specific_modulus, 0);
  EXPECT_TRUE(std::isfinite(found.candidate.specific_modulus));
  for (const double alpha : found.candidate.damping.parameters) EXPECT_TRUE(std::isfinite(alpha));
}

TEST(MaterialHard, SilentClipGivesItsReason) {
  test::Recorded silent;
  silent.samples.assign(44100, 0);
  silent.set.sample_rate = 44100;
  silent.set.end = 1;
  silent.set.nothing = "silent";
  EXPECT_NE(message_of(silent, test::free_bar(1e7, 0.3, 0.008, 16)).find("silent"),
            std::string::npos);
}

TEST(MaterialHard, FewerFeaturesThanParameters) {
  const auto tones = bar_tones(synth::damping::rayleigh_damping(5, 1e-7));
  const auto recorded = test::record({tones[0], tones[1]});
  material::MaterialOptions options;
  options.law = {synth::damping::DampingKind::hybrid, 3, ""};
  const std::string message = message_of(recorded, test::free_bar(1e7, 0.3, 0.008, 16), options);
  EXPECT_NE(message.find("2 features of the recording cannot begin a hybrid"), std::string::npos)
      << message;
}

TEST(MaterialHard, OneFeatureAndOneParameterAreAmbiguous) {
  const auto tones = bar_tones(synth::damping::rayleigh_damping(5, 0));
  material::MaterialOptions options;
  options.law = {synth::damping::DampingKind::caughey, 1, ""};
  const auto found = estimate(test::record({tones[0]}), options);
  expect_finite(found);
  EXPECT_TRUE(std::isinf(found.modulus_error));
}

TEST(MaterialHard, BodyWithoutModesInTheBand) {
  const auto recorded = test::record(bar_tones(synth::damping::rayleigh_damping(5, 1e-7)));
  material::StruckModes none;
  none.specific_modulus = 1e7;
  EXPECT_NE(message_of(recorded, none).find("no mode in its band"), std::string::npos);
}

TEST(MaterialHard, PointWhereNothingRings) {
  const auto recorded = test::record(bar_tones(synth::damping::rayleigh_damping(5, 1e-7)));
  material::StruckModes still = test::free_bar(1e7, 0.3, 0.008, 16);
  std::fill(still.gains.begin(), still.gains.end(), 0.0);
  EXPECT_NE(message_of(recorded, still).find("rings no mode"), std::string::npos);
}

TEST(MaterialHard, FeaturesThatFitNoMode) {
  // Harmonics of a string against the modes of a bar.
  std::vector<features::Feature> string;
  for (int n = 1; n <= 30; ++n) string.push_back(tone(440.0 * n, 3 + 0.2 * n, 1.0 / n));
  const auto found = estimate(test::record(string));
  expect_finite(found);
  EXPECT_TRUE(remarked(found, "poorly determined"));
}

TEST(MaterialHard, IdenticalFeatures) {
  const std::vector<features::Feature> same(5, tone(700, 10, 0.2));
  // One frequency tells nothing of two parameters.
  const auto recorded = test::record(same, {.random_phases = false});
  const std::string message = message_of(recorded, test::free_bar(1e7, 0.3, 0.008, 16));
  EXPECT_NE(message.find("5 features of the recording cannot begin"), std::string::npos) << message;
}

TEST(MaterialHard, CandidatesBeyondCritical) {
  // Thuds: so strongly damped that many candidates have no tone at all.
  std::vector<features::Feature> thuds;
  for (int n = 1; n <= 6; ++n) thuds.push_back(tone(150.0 * n, 300.0 + 50 * n, 0.5));
  expect_finite(estimate(test::record(thuds, {.seconds = 0.2})));
}

TEST(MaterialHard, CaugheyMayDipBelowZero) {
  // Damping that falls with frequency draws a series below zero beyond the features.
  auto tones = bar_tones(synth::damping::rayleigh_damping(20, 1e-8));
  for (std::size_t i = 0; i < tones.size(); ++i) tones[i].decay_rate = 12 - 1.2 * i;
  tones.resize(8);
  material::MaterialOptions options;
  options.law = {synth::damping::DampingKind::caughey, 3, ""};
  const auto found = estimate(test::record(tones), options);
  expect_finite(found);
  for (const features::Feature& heard : found.tones) EXPECT_GE(heard.decay_rate, 0);
}

TEST(MaterialHard, FormulaThatIsNoNumberEverywhere) {
  material::MaterialOptions options;
  options.law = {synth::damping::DampingKind::expression, 2, "alpha1 + alpha2*sqrt(f - 300)"};
  auto tones = bar_tones(synth::damping::rayleigh_damping(20, 1e-7));
  std::erase_if(tones, [](const features::Feature& one) { return one.frequency < 320; });
  expect_finite(estimate(test::record(tones), options));
}

TEST(MaterialHard, ShortAndSlowRates) {
  const auto tones = bar_tones(synth::damping::rayleigh_damping(20, 1e-7));
  for (const double rate : {8000.0, 192000.0}) {
    std::vector<features::Feature> heard = tones;
    std::erase_if(heard, [&](const features::Feature& one) { return one.frequency > 0.45 * rate; });
    const auto recorded = test::record(heard, {.seconds = 0.15, .sample_rate = rate});
    const auto found = estimate(recorded);
    EXPECT_NEAR(found.candidate.specific_modulus / 2.5e7, 1, 0.003) << rate;
  }
}

TEST(MaterialHard, LongSilenceAfterTheSound) {
  // Features that end long before the clip does.
  const auto recorded = test::record(bar_tones(synth::damping::rayleigh_damping(200, 1e-7)),
                                     {.seconds = 5, .snr = 60});
  const auto found = estimate(recorded);
  EXPECT_NEAR(found.candidate.specific_modulus / 2.5e7, 1, 0.003);
}

}  // namespace
}  // namespace carillon::eval
