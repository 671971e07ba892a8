#include "eval/material/pitch_estimate.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "core/error.hpp"
#include "core/random.hpp"
#include "tests/eval/struck_bodies.hpp"

namespace carillon::eval {
namespace {

enum class Body { bar, plate, ring };
const Body bodies[] = {Body::bar, Body::plate, Body::ring};
constexpr double assumed = 2.8e7;  // E / density of the modes [m^2/s^2]

material::StruckModes body(Body shape, double modulus) {
  switch (shape) {
    case Body::bar:
      return test::free_bar(modulus, 0.25, 0.01, 20);
    case Body::plate:
      return test::hinged_plate(modulus, 0.2, 0.15, 0.004, 60);
    default:
      return test::free_ring(modulus, 0.06, 0.006, 20);
  }
}

/// Closed forms as pitches; those of elements would be sharp by `error` cents, the more the higher.
material::ModePitches pitches_of(Body shape, double error = 0) {
  const material::StruckModes modes = body(shape, assumed);
  material::ModePitches pitches;
  pitches.poisson_ratio = 0.25;
  pitches.specific_modulus = assumed;
  pitches.complete_to_hz = modes.complete_to_hz;
  for (const double eigenvalue : modes.eigenvalues) {
    const double frequency = std::sqrt(eigenvalue) / (2 * M_PI);
    const double cents = error * (0.2 + frequency / 10000);
    pitches.errors.push_back(cents);
    pitches.frequencies.push_back(frequency * std::exp2(cents / 1200));
  }
  // Where it is struck is not known.
  pitches.weights = material::audibility(
      pitches.frequencies,
      Eigen::MatrixXd::Ones(static_cast<Eigen::Index>(pitches.frequencies.size()), 1));
  return pitches;
}

features::Feature feature(double frequency, double decay_rate, double snr) {
  features::Feature made;
  made.frequency = std::sqrt(frequency * frequency - std::pow(decay_rate / (2 * M_PI), 2));
  made.decay_rate = decay_rate;
  made.amplitude = std::pow(10, snr / 20);
  made.snr = snr;
  made.frequency_error = 0.02 * decay_rate * std::pow(10, -snr / 40);
  made.decay_rate_error = 2 * M_PI * made.frequency_error;
  return made;
}

/// How a recording differs from the closed form.
struct Recording {
  double modulus = 2e7;
  double scatter = 0;     ///< of the object's pitches [cents]
  double level = 10;      ///< scatter of the levels [dB]
  double missing = 0.33;  ///< share of the modes that are not heard
  double spurious = 5;    ///< tones that are no mode's, on average, 10 to 40 dB down
  double companions = 0;  ///< weak features beside each mode's
  double damping = 0.1;   ///< scatter of decay rates
  std::uint64_t seed = 1;
};
const synth::damping::DampingModel damping = synth::damping::rayleigh_damping(8, 4e-8);

features::FeatureSet heard(Body shape, const Recording& how) {
  core::RandomStream random(how.seed, 0, "test.pitches");
  const auto c = synth::damping::damping_function(damping);
  features::FeatureSet set;
  for (const double eigenvalue : body(shape, how.modulus).eigenvalues) {
    const double cents = how.scatter * random.normal();
    const double snr = 60 + how.level * random.normal();
    const double rate = 0.5 * c(eigenvalue) * std::exp(how.damping * random.normal());
    const bool missing = random.uniform() < how.missing;
    const double frequency = std::sqrt(eigenvalue) / (2 * M_PI) * std::exp2(cents / 1200);
    if (missing || frequency > 19000 || frequency < 50) continue;
    features::Feature tone = feature(frequency, rate, snr);
    tone.frequency += tone.frequency_error * random.normal();
    set.features.push_back(tone);
    for (int k = 0; k < how.companions; ++k) {
      set.features.push_back(feature(frequency * (1 + 0.004 * random.normal()),
                                     rate * random.uniform(1, 6), snr - random.uniform(10, 30)));
    }
  }
  const double spurious = how.spurious * random.uniform(0, 2);
  for (int k = 0; k < spurious; ++k) {
    const double frequency = 100 * std::pow(150, random.uniform());
    set.features.push_back(feature(frequency, random.uniform(5, 100), random.uniform(20, 50)));
  }
  return set;
}

material::PitchEstimate estimate(const features::FeatureSet& set,
                                 const material::ModePitches& modes) {
  return material::estimate_from_pitches({&set, 1}, {&modes, 1}, {});
}

bool holds(const core::Range& range, double value) {
  return range.low <= value && value <= range.high;
}

TEST(HeardTones, AreOneForAModeAndItsCompanions) {
  features::FeatureSet set;
  set.features = {feature(1000, 5, 60), feature(1004, 30, 40), feature(996, 50, 35),
                  feature(2000, 5, 50), feature(3000, 5, 10)};
  set.features.back().reverberant = true;
  const auto tones = material::heard_tones({&set, 1});
  ASSERT_EQ(tones.size(), 2U);  // the last one is 50 dB down
  EXPECT_NEAR(std::exp(tones[0].log_frequency), 1000, 1e-9);
  EXPECT_EQ(tones[0].heads.size(), 1U);
  EXPECT_DOUBLE_EQ(tones[0].certainty, 0.9);
  EXPECT_NEAR(tones[1].certainty, 0.9 * std::pow(10, -0.2), 1e-12);
}

TEST(HeardTones, OfTwoMicrophonesAreJoined) {
  features::FeatureSet sets[2];
  sets[0].features = {feature(1000, 5, 60), feature(2000, 5, 40)};
  sets[1].features = {feature(2001, 5, 30), feature(5000, 5, 20)};
  const auto tones = material::heard_tones(sets);
  ASSERT_EQ(tones.size(), 3U);
  ASSERT_EQ(tones[1].heads.size(), 2U);
  EXPECT_EQ(tones[1].heads[0].recording, 1U);  // the strongest there, 20 dB down in the other
  EXPECT_NEAR(tones[1].certainty, 1 - 0.1 * (1 - 0.9 * std::pow(10, -0.4)), 1e-12);
}

TEST(PitchLikelihood, IsThatOfItsFormula) {
  // One tone, two modes; the density is Boost's.
  features::FeatureSet set;
  set.features = {feature(1000, 1e-6, 60)};
  const auto tones = material::heard_tones({&set, 1});
  material::ModePitches modes;
  modes.specific_modulus = assumed;
  modes.frequencies = {1003, 1500};
  modes.errors = {0, 0};
  modes.weights = {0.5, 1};
  modes.complete_to_hz = 15000;
  const double scatter = 7 * std::log(2) / 1200;
  const boost::math::students_t t(4);
  const double density = 0.5 / 1.5 * boost::math::pdf(t, std::log(1.003) / scatter) / scatter;
  const double expected = std::log(0.1 + 0.9 * std::log(15000 / 50.0) * density);
  EXPECT_NEAR(material::log_likelihood(tones, modes, assumed, {0.25, 0, 7}), expected, 1e-6);
  // A modulus four times as high doubles frequencies, and is no match; nor can modes be known
  // further down than they go.
  EXPECT_NEAR(material::log_likelihood(tones, modes, 4 * assumed, {0.25, 0, 7}), std::log(0.1),
              1e-6);
  EXPECT_EQ(material::log_likelihood(tones, modes, 1e-3 * assumed, {0.25, 0, 7}), 0);
}

TEST(PitchEstimate, FindsClosedForms) {
  for (const Body shape : bodies) {
    SCOPED_TRACE(static_cast<int>(shape));
    const auto set = heard(shape, {.level = 0, .missing = 0, .spurious = 0, .damping = 1e-3});
    const auto found = estimate(set, pitches_of(shape));
    ASSERT_TRUE(found.complete()) << found.undetermined;
    EXPECT_NEAR(*found.specific_modulus / 2e7, 1, 5e-4);
    EXPECT_TRUE(holds(found.modulus95, 2e7));
    EXPECT_LT(found.modulus95.high / found.modulus95.low, 1.002);
    EXPECT_NEAR(found.damping->model.parameters[0], 8, 0.2);
    EXPECT_NEAR(found.damping->model.parameters[1], 4e-8, 1e-9);
    EXPECT_LT(found.chance, 1e-3);
  }
}

TEST(PitchEstimate, OfASteelBarIsRightOrNotDetermined) {
  // The case that began it: levels scattered by 10 dB, a third of the modes missing, other tones.
  int stated = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto set =
        heard(Body::bar, {.modulus = 2e11 / 7850, .scatter = 3, .spurious = 6, .seed = seed});
    const auto found = estimate(set, pitches_of(Body::bar));
    if (!found.specific_modulus) continue;
    ++stated;
    EXPECT_NEAR(*found.specific_modulus / (2e11 / 7850), 1, 0.02) << seed;
  }
  EXPECT_GE(stated, 10);
}

TEST(PitchEstimate, StandsCompanions) {
  const auto alone = heard(Body::plate, {.scatter = 3, .seed = 4});
  const auto crowd = heard(Body::plate, {.scatter = 3, .companions = 5, .seed = 4});
  ASSERT_GT(crowd.features.size(), 4 * alone.features.size());
  const auto found = estimate(crowd, pitches_of(Body::plate));
  ASSERT_TRUE(found.specific_modulus) << found.undetermined;
  EXPECT_TRUE(holds(found.modulus95, 2e7));
}

TEST(PitchEstimate, IntervalsHold) {
  // Made sounds of unknown points in rooms, as their features: 95 % intervals are to hold in 90 to
  // 99 % of them. The longer study is scripts/bench_estimates --coverage 20.
  int stated = 0;
  int modulus = 0;
  int damped = 0;
  int alpha[2] = {0, 0};
  int wrong = 0;
  int trials = 0;
  for (const Body shape : bodies) {
    for (const double scatter : {0.0, 2.0, 8.0}) {
      for (int trial = 0; trial < 25; ++trial) {
        const std::uint64_t seed = ++trials;
        core::RandomStream random(seed, 1, "test.coverage");
        const double truth = 1e7 * std::pow(5, random.uniform());
        const auto set = heard(shape, {.modulus = truth, .scatter = scatter, .seed = seed});
        const auto found = estimate(set, pitches_of(shape, 4));
        if (!found.specific_modulus) continue;
        ++stated;
        modulus += holds(found.modulus95, truth);
        wrong += std::abs(std::log(*found.specific_modulus / truth)) > 0.05;
        if (!found.damping) continue;
        ++damped;
        for (int k = 0; k < 2; ++k) {
          alpha[k] += holds(found.damping->confidence95[k], damping.parameters[k]);
        }
      }
    }
  }
  fmt::print(
      "{} of {} stated, {} far off; E / density holds in {:.1f} %, alphas in {:.1f} and "
      "{:.1f} % of {}\n",
      stated, trials, wrong, 100.0 * modulus / stated, 100.0 * alpha[0] / damped,
      100.0 * alpha[1] / damped, damped);
  EXPECT_GE(stated, 0.7 * trials);
  EXPECT_LE(wrong, 0.02 * stated);
  EXPECT_GE(modulus, 0.9 * stated);
  EXPECT_LE(modulus, 0.995 * stated);
  EXPECT_GE(alpha[0], 0.9 * damped);
  EXPECT_GE(alpha[1], 0.9 * damped);
}

TEST(PitchEstimate, OfAnotherObjectIsNotDetermined) {
  int stated = 0;
  for (const Body shape : bodies) {
    for (const Body other : bodies) {
      if (other == shape) continue;
      for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        const auto set = heard(shape, {.scatter = 2, .seed = seed});
        stated += estimate(set, pitches_of(other)).specific_modulus.has_value();
      }
    }
  }
  fmt::print("{} of 60 are stated\n", stated);
  EXPECT_LE(stated, 3);
}

TEST(PitchEstimate, OfNoiseIsNotDetermined) {
  int stated = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto set = heard(Body::plate, {.missing = 1, .spurious = 25, .seed = seed});
    const auto found = estimate(set, pitches_of(Body::plate));
    stated += found.specific_modulus.has_value();
    if (!found.specific_modulus) {
      EXPECT_FALSE(found.damping);
      EXPECT_TRUE(found.matches.empty());
      EXPECT_FALSE(found.undetermined.empty());
    }
  }
  EXPECT_LE(stated, 1);
}

TEST(PitchEstimate, OfTwoTonesIsNotDetermined) {
  features::FeatureSet set = heard(Body::bar, {.missing = 0, .spurious = 0});
  set.features.resize(2);
  const auto found = estimate(set, pitches_of(Body::bar));
  EXPECT_FALSE(found.specific_modulus);
  EXPECT_NE(found.undetermined.find("three"), std::string::npos);
}

TEST(PitchEstimate, TakesALargerBodyForASofterOne) {
  auto set = heard(Body::plate, {.missing = 0, .spurious = 0});
  for (features::Feature& tone : set.features) tone.frequency /= 1.01;
  const auto found = estimate(set, pitches_of(Body::plate));
  ASSERT_TRUE(found.specific_modulus);
  EXPECT_NEAR(*found.specific_modulus / 2e7, 1 / (1.01 * 1.01), 5e-4);
  EXPECT_NE(found.remarks.back().find("1 % larger"), std::string::npos);
}

TEST(PitchEstimate, DoesNotDependOnGain) {
  const auto set = heard(Body::ring, {.scatter = 2, .seed = 3});
  auto quiet = set;
  for (features::Feature& tone : quiet.features) tone.amplitude *= 0.01;
  const auto one = estimate(set, pitches_of(Body::ring));
  ASSERT_TRUE(one.specific_modulus);
  EXPECT_EQ(*one.specific_modulus, *estimate(quiet, pitches_of(Body::ring)).specific_modulus);
}

TEST(PitchEstimate, IsSurerOfMoreModes) {
  // The same microphone twice tells nothing new of the object; another one that hears other modes
  // does.
  const features::FeatureSet first = heard(Body::plate, {.scatter = 8, .missing = 0.5, .seed = 5});
  const features::FeatureSet other = heard(Body::plate, {.scatter = 8, .missing = 0, .seed = 6});
  const auto modes = pitches_of(Body::plate);
  const auto width = [&](const std::vector<features::FeatureSet>& sets) {
    const auto found = material::estimate_from_pitches(sets, {&modes, 1}, {});
    EXPECT_TRUE(found.specific_modulus) << found.undetermined;
    return std::log(found.modulus95.high / found.modulus95.low);
  };
  const double alone = width({first});
  EXPECT_GT(width({first, first}), 0.7 * alone);
  EXPECT_LT(width({first, other}), 0.9 * alone);
}

TEST(PitchEstimate, FindsPoissonsRatio) {
  // Half of the modes stiffen with Poisson's ratio, half do not.
  std::vector<material::ModePitches> sets;
  for (int step = 1; step <= 9; ++step) {
    material::ModePitches set = pitches_of(Body::plate);
    set.poisson_ratio = 0.05 * step;
    for (std::size_t i = 0; i < set.frequencies.size(); i += 2) {
      set.frequencies[i] *= 1 - 0.3 * (set.poisson_ratio - 0.25);
    }
    sets.push_back(set);
  }
  const auto set = heard(Body::plate, {.scatter = 1, .spurious = 3});
  const auto found = material::estimate_from_pitches({&set, 1}, sets, {});
  ASSERT_TRUE(found.specific_modulus) << found.undetermined;
  EXPECT_TRUE(holds(found.modulus95, 2e7));
  ASSERT_TRUE(found.poisson_ratio);
  EXPECT_TRUE(holds(found.poisson95, 0.25));
  EXPECT_LT(found.poisson95.high - found.poisson95.low, 0.1);
}

TEST(PitchEstimate, WithoutModesIsRefused) {
  const auto set = heard(Body::plate, {});
  material::ModePitches none;
  none.specific_modulus = assumed;
  EXPECT_THROW(estimate(set, none), core::InputError);
  EXPECT_THROW(material::estimate_from_pitches({&set, 1}, {}, {}), core::InputError);
}

}  // namespace
}  // namespace carillon::eval
