#include "eval/perception/compare_sounds.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.hpp"
#include "tests/eval/struck_bodies.hpp"

namespace carillon::eval {
namespace {

features::Feature mode(double frequency, double decay_rate, double amplitude) {
  features::Feature one;
  one.frequency = frequency;
  one.decay_rate = decay_rate;
  one.amplitude = amplitude;
  return one;
}

const std::vector<features::Feature> bowl = {mode(523, 8, 0.4), mode(1480, 15, 0.5),
                                             mode(3950, 60, 0.25)};

perception::HeardSound sound(const std::vector<features::Feature>& modes,
                             const test::RecordedOptions& options = {}) {
  auto recorded = test::record(modes, options);
  return {std::move(recorded.samples), std::move(recorded.set)};
}

perception::HeardSound louder(perception::HeardSound one, double decibels) {
  const double gain = std::pow(10, decibels / 20);
  for (double& sample : one.samples) sample *= gain;
  for (features::Feature& feature : one.set.features) feature.amplitude *= gain;
  return one;
}

TEST(CompareSounds, OfASoundAgainstItselfIsNothing) {
  const perception::HeardSound one = sound(bowl);
  const perception::SoundComparison same = perception::compare_sounds(one, one);
  EXPECT_EQ(same.level, 0);
  EXPECT_EQ(same.seconds, 1);
  EXPECT_EQ(same.modes.pitch.worst, 0);
  EXPECT_EQ(same.loudness.rms, 0);
  EXPECT_EQ(same.loudness.fraction, 0);
  EXPECT_EQ(same.loudness.reference_loudest, same.loudness.other_loudest);
  EXPECT_EQ(same.spectra.total(), 0);
}

TEST(CompareSounds, HearsAGain) {
  const perception::HeardSound one = sound(bowl);
  double last = 0;
  for (const double gain : {-1.0, -3.0, -10.0, -30.0}) {
    const perception::SoundComparison quieter = perception::compare_sounds(one, louder(one, gain));
    EXPECT_NEAR(quieter.level, gain, 1e-9);
    EXPECT_NEAR(quieter.modes.level.mean, -gain, 1e-9);
    EXPECT_NEAR(quieter.spectra.convergence, 1 - std::pow(10, gain / 20), 1e-3);
    EXPECT_LT(quieter.loudness.other_loudest, quieter.loudness.reference_loudest);
    EXPECT_GT(quieter.loudness.fraction, last);
    last = quieter.loudness.fraction;
  }
}

TEST(CompareSounds, LoudnessIsZwickers) {
  // A lasting tone in the middle of a band, far above the threshold: ten decibels are a factor r of
  // 10^0.23, and the difference (r - 1) / sqrt((1 + r^2) / 2) of both.
  const perception::HeardSound quiet = sound({mode(998.4, 1e-9, 0.01)}, {.seconds = 0.5});
  const perception::SoundComparison ten =
      perception::compare_sounds(quiet, louder(quiet, 10), {{}, 110});
  const double r = std::pow(10, 0.23);
  // What leaks into other bands comes up from near the threshold, where loudness grows faster.
  EXPECT_GT(ten.loudness.other_loudest / ten.loudness.reference_loudest, r);
  EXPECT_LT(ten.loudness.other_loudest / ten.loudness.reference_loudest, 1.05 * r);
  EXPECT_NEAR(ten.loudness.fraction, (r - 1) / std::sqrt((1 + r * r) / 2), 0.01);
  // One tone of 60 dB in one band of 998.4 Hz: 1.5406 sone/Bark (loudness_test.cpp), and what leaks
  // into the bands beside it.
  const perception::SoundComparison sixty = perception::compare_sounds(quiet, quiet, {{}, 60});
  EXPECT_GT(sixty.loudness.reference_loudest, 1.54);
  EXPECT_LT(sixty.loudness.reference_loudest, 1.54 * 1.2);
  // Below the threshold nothing is heard.
  const perception::SoundComparison none =
      perception::compare_sounds(quiet, louder(quiet, -5), {{}, 0});
  EXPECT_EQ(none.loudness.reference_loudest, 0);
  EXPECT_EQ(none.loudness.rms, 0);
  EXPECT_TRUE(std::isnan(none.loudness.fraction));
}

TEST(CompareSounds, IsSymmetricButForTheReferencesShare) {
  const perception::HeardSound one = sound(bowl);
  const perception::HeardSound two =
      sound({mode(530, 10, 0.3), mode(1470, 12, 0.5), mode(6000, 60, 0.2)});
  const perception::SoundComparison forth = perception::compare_sounds(one, two),
                                    back = perception::compare_sounds(two, one);
  EXPECT_NEAR(forth.level, -back.level, 1e-9);
  EXPECT_EQ(forth.loudness.rms, back.loudness.rms);
  EXPECT_EQ(forth.loudness.fraction, back.loudness.fraction);
  EXPECT_EQ(forth.loudness.reference_loudest, back.loudness.other_loudest);
  EXPECT_NEAR(forth.spectra.log_magnitude, back.spectra.log_magnitude, 1e-12);
  EXPECT_NEAR(forth.modes.decay.mean, back.modes.decay.mean, 1e-12);
  EXPECT_GT(forth.loudness.fraction, 0.1);
}

TEST(CompareSounds, LaysOnsetsOnEachOther) {
  const perception::HeardSound one = sound(bowl);
  perception::HeardSound late = one;
  late.samples.insert(late.samples.begin(), 3000, 0.0);
  late.set.onset = 3000.0 / 44100;
  late.set.end = 1 + late.set.onset;
  // A second strike comes 0.6 s after the first: it is not compared.
  late.set.end = late.set.onset + 0.6;
  late.samples[3000 + 30000] = 5;
  perception::HeardSound early = one;
  early.set.end = 0.6;
  const perception::SoundComparison same = perception::compare_sounds(early, late);
  EXPECT_NEAR(same.seconds, 0.6, 1e-4);
  EXPECT_NEAR(same.loudness.fraction, 0, 1e-9);
  EXPECT_NEAR(same.spectra.total(), 0, 1e-9);
}

TEST(CompareSounds, OfUnequalLengthsComparesWhatBothHave) {
  const perception::HeardSound longer = sound(bowl, {.seconds = 2}),
                               shorter = sound(bowl, {.seconds = 0.4});
  const perception::SoundComparison common = perception::compare_sounds(longer, shorter);
  EXPECT_NEAR(common.seconds, 0.4, 1e-4);
  EXPECT_LT(common.loudness.fraction, 1e-3);
}

TEST(CompareSounds, OfTwoRatesComparesAtTheLower) {
  const perception::HeardSound one = sound(bowl, {.seconds = 0.5, .sample_rate = 44100});
  const perception::HeardSound other = sound(bowl, {.seconds = 0.5, .sample_rate = 96000});
  const perception::SoundComparison same = perception::compare_sounds(one, other);
  EXPECT_EQ(same.sample_rate, 44100);
  EXPECT_NEAR(same.seconds, 0.5, 1e-4);
  EXPECT_NEAR(same.level, 0, 0.05);
  EXPECT_LT(same.loudness.fraction, 0.05);
  EXPECT_LT(same.spectra.convergence, 0.05);
}

TEST(CompareSounds, OfSilenceHasStatedOutcomes) {
  perception::HeardSound silence = sound({}, {.seconds = 1});
  std::fill(silence.samples.begin(), silence.samples.end(), 0.0);
  silence.set.end = 0;
  silence.set.nothing = "silent";
  const perception::SoundComparison lost = perception::compare_sounds(sound(bowl), silence);
  EXPECT_NEAR(lost.loudness.fraction, std::sqrt(2), 1e-12);
  EXPECT_EQ(lost.loudness.other_loudest, 0);
  EXPECT_EQ(lost.level, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(lost.modes.reference_fraction, 0);
  const perception::SoundComparison none = perception::compare_sounds(silence, silence);
  EXPECT_TRUE(std::isnan(none.level));
  EXPECT_EQ(none.loudness.rms, 0);
  EXPECT_EQ(none.spectra.total(), 0);
  perception::HeardSound over = sound(bowl);
  over.set.onset = 3;
  EXPECT_THROW(perception::compare_sounds(over, over), core::InputError);
  EXPECT_THROW(perception::compare_sounds({{}, {}}, over), core::InputError);
}

TEST(CompareSounds, FallsWithWhatIsExtracted) {
  // From samples alone, through the extractor: 8 cents, 15 % and 2 dB of the second mode.
  auto changed = bowl;
  changed[1] = mode(1480 * std::exp2(8.0 / 1200), 15 * 1.15, 0.5 * std::pow(10, 0.1));
  const auto extracted = [](const std::vector<features::Feature>& modes) {
    perception::HeardSound one = sound(modes, {.snr = 60});
    one.set = features::extract_features(one.samples, 44100);
    return one;
  };
  const perception::SoundComparison found =
      perception::compare_sounds(extracted(bowl), extracted(changed));
  ASSERT_EQ(found.modes.matched.size(), 3U);
  EXPECT_NEAR(found.modes.matched[1].cents, 8, 0.1);
  EXPECT_NEAR(found.modes.matched[1].decay_ratio, 1.15, 0.01);
  EXPECT_NEAR(found.modes.matched[1].level, 2, 0.1);
  EXPECT_LT(found.modes.matched[0].pitch_jnd, 0.05);
  EXPECT_GT(found.modes.reference_fraction, 0.9999);
}

}  // namespace
}  // namespace carillon::eval
