// What recordings of struck objects are held against: spectra of a stretch, peaks, tones,
// materials.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "core/error.hpp"
#include "eval/material/joint_estimate.hpp"
#include "eval/recorded/compare_recorded.hpp"
#include "eval/recorded/peak_match.hpp"
#include "struck_bodies.hpp"

namespace carillon::eval {
namespace {

constexpr double audio_rate = 48000;
constexpr double turn = 2 * std::numbers::pi;

/// a exp(-d t) cos(2 pi f t + phase) from sample 0 on.
std::vector<double> ring(double frequency, double decay_rate, double amplitude, double phase,
                         std::size_t count) {
  std::vector<double> samples;
  for (std::size_t n = 0; n < count; ++n) {
    const double t = static_cast<double>(n) / audio_rate;
    samples.push_back(amplitude * std::exp(-decay_rate * t) *
                      std::cos(turn * frequency * t + phase));
  }
  return samples;
}

/// The transform of that ring's stretch under the Blackman-Harris window, in closed form: seven
/// geometric series for each of the ring's two exponentials.
double closed_form(double frequency, double decay_rate, double amplitude, double phase,
                   const recorded::Stretch& stretch, double at) {
  using Complex = std::complex<double>;
  constexpr double terms[] = {0.35875, -0.48829, 0.14128, -0.01168};
  const auto count = static_cast<double>(stretch.end - stretch.first);
  const auto first = static_cast<double>(stretch.first);
  Complex sum = 0;
  for (const double side : {-1.0, 1.0}) {
    const Complex pole(-decay_rate / audio_rate, side * turn * frequency / audio_rate);
    const Complex start = 0.5 * amplitude * std::polar(1.0, side * phase) * std::exp(pole * first);
    for (int term = -3; term <= 3; ++term) {
      const double weight = terms[std::abs(term)] * (term == 0 ? 1 : 0.5);
      const Complex ratio = std::exp(pole + Complex(0, turn * (term / count - at / audio_rate)));
      sum += weight * start * (1.0 - std::pow(ratio, count)) / (1.0 - ratio);
    }
  }
  return 2 * std::abs(sum) / (terms[0] * count);
}

TEST(WindowSpectrum, OfADecayingSinusoidIsItsClosedForm) {
  const recorded::Stretch stretch;
  for (const auto& [frequency, decay] : {std::pair(1234.5, 0.0), {440.0, 30.0}, {9876.0, 300.0}}) {
    const auto samples = ring(frequency, decay, 0.7, 0.4, 4000);
    const recorded::WindowSpectrum spectrum =
        recorded::window_spectrum(samples, audio_rate, stretch);
    ASSERT_EQ(spectrum.amplitudes.size(), 2970U / 2 + 1);
    EXPECT_DOUBLE_EQ(spectrum.bin_width, audio_rate / 2970);
    for (std::size_t bin = 0; bin < spectrum.amplitudes.size(); ++bin) {
      const double truth = closed_form(frequency, decay, 0.7, 0.4, stretch,
                                       static_cast<double>(bin) * spectrum.bin_width);
      ASSERT_NEAR(spectrum.amplitudes[bin], truth, 1e-10) << bin;
    }
  }
}

TEST(WindowSpectrum, ShowsALastingTonesAmplitudeAndHidesItsSideLobes) {
  const double frequency = 200 * audio_rate / 2970;  // in the middle of a bin
  const auto spectrum = recorded::window_spectrum(ring(frequency, 0, 0.3, 1, 3000), audio_rate);
  EXPECT_NEAR(spectrum.amplitudes[200], 0.3, 1e-6);
  for (std::size_t bin = 210; bin < 1480; ++bin) EXPECT_LT(spectrum.amplitudes[bin], 0.3e-4);
}

TEST(WindowSpectrum, CountsWhatIsMissingAsSilenceAndRefusesWhatIsNoSound) {
  const auto samples = ring(1000, 50, 1, 0, 1500);
  auto padded = samples;
  padded.resize(3000);
  EXPECT_EQ(recorded::window_spectrum(samples, audio_rate).amplitudes,
            recorded::window_spectrum(padded, audio_rate).amplitudes);
  EXPECT_EQ(recorded::window_spectrum({}, audio_rate).amplitudes[7], 0);
  EXPECT_TRUE(recorded::highest_peaks(recorded::window_spectrum({}, audio_rate), 10, 20).empty());
  padded[100] = std::nan("");
  EXPECT_THROW(recorded::window_spectrum(padded, audio_rate), core::InputError);
  EXPECT_THROW(recorded::window_spectrum(samples, 0), core::InputError);
  EXPECT_THROW(recorded::window_spectrum(samples, audio_rate, {.first = 5, .end = 6}),
               core::InputError);
}

/// A peak lies where the closed form of the transform has its maximum, to a hundredth of a bin, and
/// is as high, to a hundredth of a decibel; of a tone that hardly decays, that is the tone itself.
RC_GTEST_PROP(HighestPeaks, LieWhereTheTransformIsHighest, ()) {
  const double frequency = *rc::gen::inRange(300, 20000) + 0.137 * *rc::gen::inRange(0, 8);
  const double decay = *rc::gen::inRange(0, 60);
  const double phase = 0.1 * *rc::gen::inRange(0, 60);
  const auto spectrum =
      recorded::window_spectrum(ring(frequency, decay, 1, phase, 3000), audio_rate);
  const auto peaks = recorded::highest_peaks(spectrum, 1, 20);
  RC_ASSERT(peaks.size() == 1U);
  const auto height = [&](double at) { return closed_form(frequency, decay, 1, phase, {}, at); };
  double low = frequency - spectrum.bin_width, high = frequency + spectrum.bin_width;
  for (int step = 0; step < 100; ++step) {
    const double a = low + (high - low) / 3, b = high - (high - low) / 3;
    (height(a) < height(b) ? low : high) = height(a) < height(b) ? a : b;
  }
  RC_ASSERT(std::abs(peaks[0].frequency - low) < 0.01 * spectrum.bin_width);
  RC_ASSERT(std::abs(20 * std::log10(peaks[0].amplitude / height(low))) < 0.04);
  RC_ASSERT(std::abs(peaks[0].frequency - frequency) < 0.02 * spectrum.bin_width);
}

TEST(HighestPeaks, AreTheHighestInOrderOfFrequency) {
  std::vector<double> samples(3000);
  const std::vector<std::pair<double, double>> tones = {
      {500, 0.2}, {900, 1}, {2000, 0.5}, {4000, 0.01}, {40, 3}};
  for (const auto& [frequency, amplitude] : tones) {
    const auto tone = ring(frequency, 5, amplitude, 0.3, samples.size());
    for (std::size_t n = 0; n < samples.size(); ++n) samples[n] += tone[n];
  }
  const auto spectrum = recorded::window_spectrum(samples, audio_rate);
  const auto three = recorded::highest_peaks(spectrum, 3, 100);
  ASSERT_EQ(three.size(), 3U);
  EXPECT_NEAR(three[0].frequency, 500, 1);
  EXPECT_NEAR(three[1].frequency, 900, 1);
  EXPECT_NEAR(three[2].frequency, 2000, 1);
  EXPECT_NEAR(recorded::highest_peaks(spectrum, 1, 20)[0].frequency, 40, 3);
  EXPECT_NEAR(recorded::scale_frequency(three, recorded::ScalePeak::highest), 900, 1);
  EXPECT_NEAR(recorded::scale_frequency(three, recorded::ScalePeak::lowest_of_ten), 500, 1);
}

std::vector<recorded::SpectralPeak> peaks_at(const std::vector<double>& frequencies) {
  std::vector<recorded::SpectralPeak> peaks;
  for (const double frequency : frequencies) peaks.push_back({frequency, 1});
  return peaks;
}

TEST(MatchPeaks, PairsEachModeWithOnePeak) {
  const std::vector<double> modes = {1000, 1010, 2000, 5000};
  const recorded::PeakMatch match = recorded::match_peaks(modes, peaks_at({1005, 2010, 3000}), 50);
  EXPECT_EQ(match.modes, 4U);
  EXPECT_EQ(match.peaks, 3U);
  // One peak for the pair of modes at 1 kHz.
  ASSERT_EQ(match.matched, 2U);
  EXPECT_NEAR(match.cents[1], 1200 * std::log2(2000.0 / 2010), 1e-9);
  // By rank: 1000, 1010, 2000 against 1005, 2010, 3000.
  EXPECT_NEAR(match.rank_rms_hz, std::sqrt((25 + 1e6 + 1e6) / 3.0), 1e-9);
  EXPECT_THROW(recorded::match_peaks(std::vector{0.0}, peaks_at({1}), 50), core::InputError);
  const recorded::PeakMatch none = recorded::match_peaks({}, {}, 50);
  EXPECT_EQ(none.matched, 0U);
  EXPECT_TRUE(std::isnan(none.rank_rms_hz));
}

TEST(PairsByChance, FollowFromHowDenseTheOthersAre) {
  // One peak each 100 cents: within 20 cents of a mode at any place two fifths of the time.
  std::vector<double> peaks, modes;
  for (int k = 0; k < 120; ++k) peaks.push_back(100 * std::exp2(k * 100.0 / 1200));
  for (int k = 0; k < 40; ++k) modes.push_back(400 * std::exp2(k * 137.0 / 1200));
  EXPECT_NEAR(recorded::pairs_by_chance(modes, peaks, 20) / 40, 0.4, 0.05);
  EXPECT_EQ(recorded::pairs_by_chance(std::vector{1000.0}, std::vector{1000.0}, 50), 0);
}

TEST(Joined, CountsAllStrikes) {
  const std::vector<double> modes = {1000, 2000};
  const std::vector<recorded::PeakMatch> two = {
      recorded::match_peaks(modes, peaks_at({1003, 2004}), 50),
      recorded::match_peaks(modes, peaks_at({1004}), 50)};
  const recorded::PeakMatch all = recorded::joined(two);
  EXPECT_EQ(all.modes, 4U);
  EXPECT_EQ(all.matched, 3U);
  EXPECT_NEAR(all.rank_rms_hz, std::sqrt((9 + 16 + 16) / 3.0), 1e-9);
}

features::Feature tone(double frequency, double decay_rate, double amplitude) {
  features::Feature feature;
  feature.frequency = frequency;
  feature.decay_rate = decay_rate;
  feature.amplitude = amplitude;
  return feature;
}

/// Strikes that are the model's but for a gain, a pitch, a damping and one mode that is too loud.
TEST(CompareRecorded, TakesOneGainOutOfAllLevels) {
  const std::vector<features::Feature> first = {tone(500, 5, 1), tone(1300, 9, 2),
                                                tone(2900, 20, 0.5)};
  const std::vector<features::Feature> second = {tone(500, 5, 3), tone(1300, 9, 0.1),
                                                 tone(4000, 30, 1)};
  const double gain = 0.004, cents = 7, damping = 1.25;
  std::vector<std::vector<features::Feature>> heard = {first, second};
  for (auto& tones : heard) {
    for (features::Feature& mode : tones) {
      mode.frequency *= std::exp2(cents / 1200);
      mode.decay_rate *= damping;
      mode.amplitude *= gain;
    }
  }
  heard[1][2].amplitude *= 2;
  heard[1].push_back(tone(9000, 40, 1e-3));
  const std::vector<recorded::RecordedTones> strikes = {{heard[0], first}, {heard[1], second}};
  const recorded::RecordedComparison found = recorded::compare_recorded(strikes, {});
  EXPECT_NEAR(found.gain / gain, 1, 1e-12);
  EXPECT_EQ(found.all.matched, 6U);
  EXPECT_EQ(found.all.recorded, 7U);
  EXPECT_NEAR(found.all.cents.median, -cents, 1e-9);
  EXPECT_NEAR(found.all.decay_ratio.median, 1 / damping, 1e-12);
  EXPECT_NEAR(found.strikes[1].matched[2].level, -20 * std::log10(2.0), 1e-9);
  EXPECT_NEAR(found.all.level_error.median, 0, 1e-9);
  ASSERT_EQ(found.strikes[1].reference_only.size(), 1U);
  EXPECT_EQ(found.strikes[1].reference_only[0], 3U);
}

TEST(CompareRecorded, LeavesOutWhatIsTooWeakAndStandsSilence) {
  const std::vector<features::Feature> loud = {tone(500, 5, 1), tone(700, 5, 1e-4)};
  const std::vector<features::Feature> none;
  const std::vector<recorded::RecordedTones> strikes = {{loud, loud}, {none, loud}};
  const recorded::RecordedComparison found = recorded::compare_recorded(strikes, {});
  EXPECT_EQ(found.all.synthetic, 2U);
  EXPECT_EQ(found.all.matched, 1U);
  const std::vector<recorded::RecordedTones> silent = {{none, {}}};
  EXPECT_TRUE(std::isnan(recorded::compare_recorded(silent, {}).all.cents.median));
}

/// A plate struck at two points: gains of its modes differ, the material does not.
TEST(EstimateJointly, FindsOneMaterialAndOneGainOfSeveralStrikes) {
  const double truth = 2.4e7;
  material::StruckModes first = test::hinged_plate(3e7, 0.2, 0.15, 0.005, 30);
  material::StruckModes second = first;
  for (std::size_t i = 0; i < second.gains.size(); ++i) {
    second.gains[i] *= 0.3 + 0.7 * std::abs(std::sin(1.7 * static_cast<double>(i)));
  }
  material::MaterialOptions options;
  options.motion = material::HeardMotion::acceleration;
  options.contact_time = 0;
  const material::Candidate material{.specific_modulus = truth,
                                     .scale = 0.02,
                                     .contact_time = 0,
                                     .damping = synth::damping::rayleigh_damping(8, 1e-7)};
  std::vector<test::Recorded> recorded;
  std::vector<material::StruckRecording> recordings;
  for (const material::StruckModes* modes : {&first, &second}) {
    const auto heard = material::heard_candidate(*modes, material, options.motion, 20, 20000);
    recorded.push_back(test::record(heard.tones, {.snr = 40}));
  }
  recordings.push_back({recorded[0].samples, &recorded[0].set, first});
  recordings.push_back({recorded[1].samples, &recorded[1].set, second});
  const features::FeatureSet nothing = [&] {
    features::FeatureSet set = recorded[0].set;
    set.features.clear();
    return set;
  }();
  recordings.push_back({recorded[0].samples, &nothing, first});
  const material::JointEstimate found = material::estimate_jointly(recordings, options);
  EXPECT_NEAR(found.candidate.specific_modulus / truth, 1, 0.003);
  EXPECT_NEAR(found.candidate.scale / 0.02, 1, 0.1);
  EXPECT_NEAR(found.candidate.damping.parameters[0] / 8, 1, 0.1);
  EXPECT_NEAR(found.candidate.damping.parameters[1] / 1e-7, 1, 0.1);
  ASSERT_EQ(found.alone.size(), 3U);
  EXPECT_FALSE(found.alone[2].has_value());
  ASSERT_EQ(found.remarks.size(), 1U);
  EXPECT_NE(found.remarks[0].find("recording 3 is left out"), std::string::npos);
  EXPECT_THROW(material::estimate_jointly({}, options), core::InputError);
}

}  // namespace
}  // namespace carillon::eval
