#include "eval/material/hybrid_metric.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.hpp"
#include "tests/eval/struck_bodies.hpp"

namespace carillon::eval {
namespace {

material::Candidate glass() {
  material::Candidate candidate;
  candidate.specific_modulus = 2.4e7;
  candidate.scale = 0.1;
  candidate.damping = synth::damping::rayleigh_damping(10, 1e-7);
  return candidate;
}

material::HeardCandidate heard(const material::Candidate& candidate) {
  return material::heard_candidate(test::free_bar(2.4e7, 0.25, 0.01, 12), candidate,
                                   material::HeardMotion::velocity, 20, 20000);
}

TEST(HybridMetric, OfTheTruthIsTheLeastThereIs) {
  const auto recorded = test::record(heard(glass()).tones, {.seconds = 0.5});
  const material::Reference reference = material::make_reference(recorded.samples, recorded.set);
  const material::MetricValue value = material::hybrid_metric(reference, heard(glass()));
  EXPECT_NEAR(value.recording_match, 1, 1e-12);
  EXPECT_NEAR(value.candidate_match, 1, 1e-12);
  EXPECT_LT(value.psychoacoustic, 1e-4);
  EXPECT_NEAR(value.metric, reference.options.min_difference, 1e-4);
  EXPECT_NEAR(material::match_ratio_product(reference, heard(glass())), 1, 1e-12);
}

TEST(HybridMetric, RisesWithEveryMismatch) {
  const auto recorded = test::record(heard(glass()).tones, {.seconds = 0.5});
  const material::Reference reference = material::make_reference(recorded.samples, recorded.set);
  const auto metric = [&](double modulus, double scale, double alpha1, double alpha2) {
    material::Candidate other = glass();
    other.specific_modulus *= modulus;
    other.scale *= scale;
    other.damping.parameters[0] *= alpha1;
    other.damping.parameters[1] *= alpha2;
    return material::hybrid_metric(reference, heard(other)).metric;
  };
  for (const double way : {-1.0, 1.0}) {
    double modulus = 0, scale = 0, alpha1 = 0, alpha2 = 0;
    for (const double step : {0.0, 0.01, 0.03, 0.1, 0.3}) {
      const double factor = std::exp(way * step);
      EXPECT_GT(metric(std::pow(factor, 0.1), 1, 1, 1), modulus) << way * step;
      EXPECT_GT(metric(1, factor, 1, 1), scale) << way * step;
      EXPECT_GT(metric(1, 1, factor, 1), alpha1) << way * step;
      EXPECT_GT(metric(1, 1, 1, factor), alpha2) << way * step;
      modulus = metric(std::pow(factor, 0.1), 1, 1, 1);
      scale = metric(1, factor, 1, 1);
      alpha1 = metric(1, 1, factor, 1);
      alpha2 = metric(1, 1, 1, factor);
    }
  }
}

TEST(HybridMetric, DoesNotDependOnGain) {
  auto recorded = test::record(heard(glass()).tones, {.seconds = 0.5, .snr = 40});
  material::Candidate other = glass();
  other.damping.parameters[0] = 15;
  const material::MetricValue loud = material::hybrid_metric(
      material::make_reference(recorded.samples, recorded.set), heard(other));
  for (double& sample : recorded.samples) sample *= 1e-4;
  for (double& sample : recorded.set.residual) sample *= 1e-4;
  for (features::Feature& feature : recorded.set.features) feature.amplitude *= 1e-4;
  other.scale *= 1e-4;
  const material::MetricValue quiet = material::hybrid_metric(
      material::make_reference(recorded.samples, recorded.set), heard(other));
  EXPECT_NEAR(loud.metric, quiet.metric, 1e-9);
}

TEST(HybridMetric, PsychoacousticPartIsSymmetric) {
  // Both ways with one scale of loudness; each as a fraction of the other's squares.
  material::Candidate other = glass();
  other.damping.parameters[0] = 20;
  other.specific_modulus *= 1.02;
  const auto one = test::record(heard(glass()).tones, {.seconds = 0.5});
  const auto two = test::record(heard(other).tones, {.seconds = 0.5});
  const material::Reference first = material::make_reference(one.samples, one.set);
  material::Reference second = material::make_reference(two.samples, two.set);
  second.loudness_scale = first.loudness_scale;
  const auto grid = second.grid;
  second.loudness = material::specific_loudness(material::band_powers(two.samples, grid), grid,
                                                first.loudness_scale);
  second.loudness_squared = 0;
  for (const double sone : second.loudness) second.loudness_squared += sone * sone;
  const double forth =
      material::hybrid_metric(first, heard(other)).psychoacoustic * first.loudness_squared;
  const double back =
      material::hybrid_metric(second, heard(glass())).psychoacoustic * second.loudness_squared;
  EXPECT_GT(forth, 0);
  EXPECT_NEAR(forth / back, 1, 0.02);
}

TEST(HybridMetric, OfSilenceIsFinite) {
  const auto recorded = test::record(heard(glass()).tones, {.seconds = 0.5});
  const material::Reference reference = material::make_reference(recorded.samples, recorded.set);
  const material::MetricValue value = material::hybrid_metric(reference, {});
  EXPECT_NEAR(value.psychoacoustic, 1, 1e-12);
  EXPECT_TRUE(std::isfinite(value.metric));
  EXPECT_GT(value.metric, 1e3);
}

TEST(HybridMetric, NegativeDampingPays) {
  const auto recorded = test::record(heard(glass()).tones, {.seconds = 0.5});
  const material::Reference reference = material::make_reference(recorded.samples, recorded.set);
  material::HeardCandidate candidate = heard(glass());
  const double without = material::hybrid_metric(reference, candidate).metric;
  candidate.negative = 0.2;
  EXPECT_NEAR(material::hybrid_metric(reference, candidate).metric, 3 * without, 1e-12);
}

TEST(HybridMetric, HearsThroughNoiseHumsAndOffset) {
  const auto clean = test::record(heard(glass()).tones, {.seconds = 0.5});
  const double silent =
      material::hybrid_metric(material::make_reference(clean.samples, clean.set), heard(glass()))
          .psychoacoustic;
  auto recorded = test::record(heard(glass()).tones, {.seconds = 0.5, .snr = 20});
  recorded.set.hums.push_back({.frequency = 100, .decay_rate = 0, .amplitude = 0.05});
  for (std::size_t i = 0; i < recorded.samples.size(); ++i) {
    recorded.samples[i] += 0.3 + 0.05 * std::cos(2 * M_PI * 100 * static_cast<double>(i) / 44100);
  }
  const double noisy = material::hybrid_metric(
                           material::make_reference(recorded.samples, recorded.set), heard(glass()))
                           .psychoacoustic;
  auto unknown = recorded.set;
  unknown.residual.clear();
  unknown.hums.clear();
  const double unheard =
      material::hybrid_metric(material::make_reference(recorded.samples, unknown), heard(glass()))
          .psychoacoustic;
  EXPECT_LT(silent, 1e-3);
  EXPECT_LT(noisy, 0.02);
  EXPECT_GT(unheard, 5 * noisy);
}

TEST(MakeReference, RefusesWhatHoldsNothing) {
  auto recorded = test::record(heard(glass()).tones, {.seconds = 0.1});
  auto silent = recorded.set;
  silent.features.clear();
  silent.nothing = "silent";
  try {
    material::make_reference(recorded.samples, silent);
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(error.message().find("silent"), std::string::npos);
  }
  recorded.set.begin = 3;
  EXPECT_THROW(material::make_reference(recorded.samples, recorded.set), core::InputError);
  recorded.set.begin = 0;
  EXPECT_THROW(material::make_reference(std::vector<double>(4410, 0.0), recorded.set),
               core::InputError);
}

}  // namespace
}  // namespace carillon::eval
