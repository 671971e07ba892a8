#include "eval/material/estimate_material.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/random.hpp"
#include "tests/eval/struck_bodies.hpp"

namespace carillon::eval {
namespace {

struct Truth {
  const char* name;
  double specific_modulus;
  synth::damping::DampingModel damping;
};
/// Steel, glass and wood of the presets.
const std::vector<Truth> materials = {
    {"steel", 2.0e11 / 7850, synth::damping::rayleigh_damping(5, 3e-8)},
    {"glass", 6.2e10 / 2600, synth::damping::rayleigh_damping(1, 1e-7)},
    {"wood", 1.1e10 / 750, synth::damping::rayleigh_damping(60, 2e-6)},
};

enum class Body { bar, plate, ring };
const Body bodies[] = {Body::bar, Body::plate, Body::ring};

material::StruckModes body(Body shape, double modulus, double size = 1) {
  switch (shape) {
    case Body::bar:
      return test::free_bar(modulus, 0.25 * size, 0.01 * size, 20);
    case Body::plate:
      return test::hinged_plate(modulus, 0.2 * size, 0.15 * size, 0.004 * size, 60);
    default:
      return test::free_ring(modulus, 0.06 * size, 0.006 * size, 20);
  }
}

material::Candidate candidate_of(const Truth& truth) {
  material::Candidate candidate;
  candidate.specific_modulus = truth.specific_modulus;
  candidate.scale = 0.1;
  candidate.contact_time = 2e-4;
  candidate.damping = truth.damping;
  return candidate;
}

std::vector<features::Feature> tones_of(
    Body shape, const Truth& truth, double size = 1,
    material::HeardMotion motion = material::HeardMotion::velocity) {
  return material::heard_candidate(body(shape, truth.specific_modulus, size), candidate_of(truth),
                                   motion, 20, 20000)
      .tones;
}

material::MaterialEstimate estimate_from(const test::Recorded& recorded,
                                         const material::StruckModes& assumed,
                                         const material::MaterialOptions& options = {}) {
  return material::estimate_material(recorded.samples, recorded.set, assumed, options);
}

double error_of(double found, double truth) {
  return std::abs(found / truth - 1);
}

TEST(EstimateMaterial, FindsTheTruthOfCleanClips) {
  for (const Truth& truth : materials) {
    for (const Body shape : bodies) {
      SCOPED_TRACE(fmt::format("{}, object {}", truth.name, static_cast<int>(shape)));
      const auto recorded = test::record(tones_of(shape, truth));
      const auto found = estimate_from(recorded, body(shape, 1e7));
      EXPECT_LT(error_of(found.candidate.specific_modulus, truth.specific_modulus), 0.001);
      EXPECT_LT(error_of(found.candidate.damping.parameters[0], truth.damping.parameters[0]), 0.01);
      EXPECT_LT(error_of(found.candidate.damping.parameters[1], truth.damping.parameters[1]), 0.01);
      EXPECT_LT(error_of(found.candidate.scale, 0.1), 0.02);
      EXPECT_LT(error_of(found.candidate.contact_time, 2e-4), 0.05);
      EXPECT_TRUE(found.converged);
      EXPECT_EQ(found.matches.size(), recorded.set.features.size());
      for (std::size_t k = 0; k < 2; ++k) {
        EXPECT_LT(found.ranges[k].low, truth.damping.parameters[k]);
        EXPECT_GT(found.ranges[k].high, truth.damping.parameters[k]);
      }
      EXPECT_EQ(found.remarks.size(), 1U) << found.remarks.front();
      for (std::size_t i = 1; i < found.minima.size(); ++i) {
        EXPECT_GT(found.minima[i].value.metric, 2 * found.value.metric);
      }
    }
  }
}

TEST(EstimateMaterial, StandsNoiseAndModesThatDoNotSound) {
  for (const Truth& truth : materials) {
    for (const Body shape : bodies) {
      SCOPED_TRACE(fmt::format("{}, object {}", truth.name, static_cast<int>(shape)));
      const auto recorded =
          test::record(tones_of(shape, truth), {.snr = 30, .missing = 0.3, .seed = 3});
      const auto found = estimate_from(recorded, body(shape, 4e7));
      EXPECT_LT(error_of(found.candidate.specific_modulus, truth.specific_modulus), 0.002);
      EXPECT_LT(error_of(found.candidate.damping.parameters[0], truth.damping.parameters[0]), 0.2);
      EXPECT_LT(error_of(found.candidate.damping.parameters[1], truth.damping.parameters[1]), 0.2);
    }
  }
}

TEST(EstimateMaterial, StaysNearWhenTheBodyIsNotTheMesh) {
  // One per cent of scatter in every frequency and 3 dB in every amplitude: a modulus goes with the
  // square, and the mean of n features is off by 2 % / sqrt(n).
  const Truth& truth = materials[1];
  auto tones = tones_of(Body::plate, truth);
  core::RandomStream random(5, 0, "test.scatter");
  for (features::Feature& tone : tones) {
    tone.frequency *= 1 + 0.01 * random.normal();
    tone.amplitude *= std::pow(10, 3 * random.normal() / 20);
  }
  const auto found = estimate_from(test::record(tones, {.snr = 40}), body(Body::plate, 1e7));
  EXPECT_LT(error_of(found.candidate.specific_modulus, truth.specific_modulus), 0.015);
  EXPECT_GT(found.modulus_error, 0.001);
  EXPECT_LT(found.modulus_error, 0.02);
  EXPECT_GT(found.rms_cents, 1);
}

TEST(EstimateMaterial, TrustsSpectrogramsAsFarAsTheyAgree) {
  // Amplitudes scattered by 6 dB and a tenth of the modes missing: a bare Pi_psycho would be made
  // smaller by wrong damping.
  const Truth& truth = materials[1];
  auto tones = tones_of(Body::plate, truth);
  core::RandomStream random(7, 0, "test.scatter");
  for (features::Feature& tone : tones) tone.amplitude *= std::pow(10, 6 * random.normal() / 20);
  const auto recorded = test::record(tones, {.snr = 40, .missing = 0.1});
  material::MaterialOptions bare;
  bare.metric.min_difference = 0;
  const auto off = [&](const material::MaterialOptions& options) {
    const auto found = estimate_from(recorded, body(Body::plate, 1e7), options);
    return error_of(found.candidate.damping.parameters[0], truth.damping.parameters[0]);
  };
  const double with = off({});
  const double without = off(bare);
  EXPECT_LT(with, 0.15);
  EXPECT_GT(without, 2 * with);
  fmt::print("alpha1 is off by {:.2f} with it and {:.2f} without\n", with, without);
}

TEST(EstimateMaterial, TakesALargerBodyForASofterOne) {
  const Truth& truth = materials[0];
  const auto recorded = test::record(tones_of(Body::bar, truth, 1.01));
  const auto found = estimate_from(recorded, body(Body::bar, 1e7));
  EXPECT_NEAR(found.candidate.specific_modulus / truth.specific_modulus, 1 / (1.01 * 1.01), 2e-4);
  EXPECT_NE(found.remarks.back().find("1 % larger"), std::string::npos);
}

TEST(EstimateMaterial, DoesNotDependOnGain) {
  const auto recorded = test::record(tones_of(Body::ring, materials[1]), {.snr = 40});
  auto quiet = recorded;
  for (double& sample : quiet.samples) sample *= 0.01;
  for (double& sample : quiet.set.residual) sample *= 0.01;
  for (features::Feature& feature : quiet.set.features) feature.amplitude *= 0.01;
  const auto one = estimate_from(recorded, body(Body::ring, 1e7));
  const auto other = estimate_from(quiet, body(Body::ring, 1e7));
  EXPECT_LT(error_of(other.candidate.specific_modulus, one.candidate.specific_modulus), 1e-5);
  EXPECT_LT(error_of(other.candidate.scale, 0.01 * one.candidate.scale), 1e-3);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_LT(error_of(other.candidate.damping.parameters[k], one.candidate.damping.parameters[k]),
              1e-3);
  }
}

TEST(EstimateMaterial, FindsEveryModel) {
  const double modulus = 2.4e7;
  const std::vector<std::pair<damping::DampingLaw, std::vector<double>>> laws = {
      {{synth::damping::DampingKind::power, 2, ""}, {0.2, 0.25}},
      {{synth::damping::DampingKind::hybrid, 3, ""}, {4, 2e-6, 0.85}},
      {{synth::damping::DampingKind::caughey, 3, ""}, {12, 3e-8, -1e-18}},
      {{synth::damping::DampingKind::expression, 2, "alpha1 + alpha2*f"}, {3, 0.01}},
  };
  for (const auto& [law, alphas] : laws) {
    SCOPED_TRACE(synth::damping::form_of(law.kind).name);
    const Truth truth{"", modulus, {law.kind, alphas, law.expression}};
    material::MaterialOptions options;
    options.law = law;
    const auto found =
        estimate_from(test::record(tones_of(Body::plate, truth)), body(Body::plate, 1e7), options);
    EXPECT_LT(error_of(found.candidate.specific_modulus, modulus), 0.001);
    // Parameters of one law can stand in for each other; its curve is what is heard.
    const auto c = synth::damping::damping_function(found.candidate.damping);
    const auto expected = synth::damping::damping_function(truth.damping);
    for (const double f : {500.0, 2000.0, 8000.0}) {
      const double lambda = std::pow(2 * M_PI * f, 2);
      EXPECT_LT(error_of(c(lambda), expected(lambda)), 0.03) << f;
    }
  }
}

TEST(EstimateMaterial, HearsAccelerationAsMicrophonesDo) {
  const Truth& truth = materials[2];
  const auto recorded = test::record(
      tones_of(Body::plate, truth, 1, material::HeardMotion::acceleration), {.snr = 40});
  material::MaterialOptions options;
  options.motion = material::HeardMotion::acceleration;
  const auto right = estimate_from(recorded, body(Body::plate, 1e7), options);
  const auto wrong = estimate_from(recorded, body(Body::plate, 1e7));
  EXPECT_LT(error_of(right.candidate.specific_modulus, truth.specific_modulus), 0.002);
  EXPECT_LT(error_of(wrong.candidate.specific_modulus, truth.specific_modulus), 0.01);
  EXPECT_LT(right.value.metric, wrong.value.metric);
}

TEST(EstimateMaterial, IsTheSameForTheSameSeed) {
  const auto recorded = test::record(tones_of(Body::ring, materials[0]), {.snr = 20, .seed = 9});
  const auto one = estimate_from(recorded, body(Body::ring, 1e7));
  const auto again = estimate_from(recorded, body(Body::ring, 1e7));
  EXPECT_EQ(one.candidate.specific_modulus, again.candidate.specific_modulus);
  EXPECT_EQ(one.candidate.damping.parameters, again.candidate.damping.parameters);
}

TEST(EstimateMaterial, SaysWhenModesEndBelowTheFeatures) {
  // Modes of a stiff assumed material to 6 kHz, a recording of a soft one to 20 kHz.
  material::StruckModes few = body(Body::plate, 4e7);
  few.eigenvalues.resize(14);
  few.gains.resize(14);
  few.complete_to_hz = std::sqrt(few.eigenvalues.back()) / (2 * M_PI);
  const auto found = estimate_from(test::record(tones_of(Body::plate, materials[2])), few);
  const bool said = std::any_of(found.remarks.begin(), found.remarks.end(), [](const auto& remark) {
    return remark.find("--max-frequency") != std::string::npos;
  });
  EXPECT_TRUE(said);
}

}  // namespace
}  // namespace carillon::eval
