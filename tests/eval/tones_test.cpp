#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "eval/features/detail/esprit.hpp"
#include "eval/features/detail/find_tones.hpp"
#include "eval/features/detail/noise_floor.hpp"
#include "eval/features/detail/tone.hpp"
#include "synth/signal/real_fft.hpp"
#include "tests/eval/strike_clip.hpp"

namespace carillon::eval {
namespace {

using Complex = std::complex<double>;

features::Tone tone_of(double omega, double decay, double size, double phase) {
  return {std::polar(size, phase), {-decay, omega}};
}

std::vector<double> samples_of(const features::Tone& tone, std::size_t count) {
  std::vector<double> samples(count);
  for (std::size_t n = 0; n < count; ++n) {
    samples[n] = (tone.amplitude * std::exp(tone.rate * static_cast<double>(n))).real();
  }
  return samples;
}

// FFTW's transform of the samples is the oracle of the closed form.
RC_GTEST_PROP(Tones, TransformsAreThoseOfTheirSamples, ()) {
  const std::size_t count = 2 * *rc::gen::inRange<std::size_t>(40, 300);
  const double omega = *rc::gen::inRange(1, 310) / 100.0;
  const double decay = std::pow(10, *rc::gen::inRange(-60, -5) / 10.0) - 1e-4;
  const features::Tone tone = tone_of(omega, decay, 0.7, *rc::gen::inRange(0, 628) / 100.0);
  synth::signal::RealFft fft(count);
  const auto samples = samples_of(tone, count);
  std::copy(samples.begin(), samples.end(), fft.signal().begin());
  fft.forward();
  const features::ToneGrid grid(count);
  std::vector<Complex> spectrum(grid.bins());
  grid.add(tone, 1, {0, grid.bins()}, spectrum);
  double largest = 0;
  for (const Complex value : fft.spectrum()) largest = std::max(largest, std::abs(value));
  for (std::size_t k = 0; k < grid.bins(); ++k) {
    RC_ASSERT(std::abs(spectrum[k] - fft.spectrum()[k]) < 1e-9 * largest);
  }
}

RC_GTEST_PROP(Tones, DerivativesAreDifferences, ()) {
  const std::size_t count = 240;
  const double omega = *rc::gen::inRange(20, 300) / 100.0;
  const features::Tone tone =
      tone_of(omega, *rc::gen::inRange(1, 50) / 1000.0, 0.7, *rc::gen::inRange(0, 628) / 100.0);
  const features::ToneGrid grid(count);
  const features::BinRange range{3, 100, *rc::gen::inRange<std::size_t>(1, 4)};
  std::vector<Complex> columns(4 * range.size());
  grid.derivatives(tone, range, columns);
  const double step = 1e-6;
  const Complex moves[4] = {{step, 0}, {0, step}, {step, 0}, {0, step}};
  for (std::size_t c = 0; c < 4; ++c) {
    std::vector<Complex> change(range.size());
    for (const double sign : {1.0, -1.0}) {
      features::Tone moved = tone;
      (c < 2 ? moved.amplitude : moved.rate) += sign * moves[c];
      grid.add_part(moved, sign / (2 * step), range, change);
    }
    double largest = 0;
    for (std::size_t i = 0; i < range.size(); ++i) {
      largest = std::max(largest, std::abs(columns[c * range.size() + i]));
    }
    for (std::size_t i = 0; i < range.size(); ++i) {
      RC_ASSERT(std::abs(change[i] - columns[c * range.size() + i]) < 1e-5 * largest);
    }
  }
}

TEST(Tones, EnergyIsTheSumOfSquares) {
  for (const double decay : {0.0, 1e-6, 1e-3, 0.05}) {
    const features::Tone tone = tone_of(1.3, decay, 0.8, 0.4);
    double sum = 0;
    for (const double sample : samples_of(tone, 5000)) sum += sample * sample;
    EXPECT_NEAR(features::energy(tone, 5000) / sum, 1, decay > 0.01 ? 0.05 : 2e-3) << decay;
  }
}

TEST(Esprit, FindsRatesExactlyWithoutNoise) {
  const std::vector<features::Tone> tones = {
      tone_of(0.500, 0.0004, 1, 0), tone_of(0.503, 0.0006, 0.5, 1), tone_of(0.520, 0.002, 0.8, 2)};
  std::vector<double> samples(5000, 0.0);
  for (const features::Tone& tone : tones) {
    const auto own = samples_of(tone, samples.size());
    for (std::size_t n = 0; n < samples.size(); ++n) samples[n] += own[n];
  }
  const features::Band band = features::take_band(samples, 0.51, 64, 48);
  EXPECT_EQ(band.values.size(), 48u);
  const auto rates = features::esprit_rates(band, 1e-6, 12);
  ASSERT_GE(rates.size(), 3u);
  for (const features::Tone& tone : tones) {
    double nearest = 1e9;
    for (const Complex rate : rates) nearest = std::min(nearest, std::abs(rate - tone.rate));
    EXPECT_LT(nearest, 1e-7);
  }
}

TEST(NoiseFloor, IsThatOfWhiteNoiseBelowLines) {
  TestRandom random(9);
  std::vector<double> samples(20000);
  for (std::size_t n = 0; n < samples.size(); ++n) {
    samples[n] = 0.1 * random.normal();
    for (int line = 1; line <= 20; ++line) {
      samples[n] +=
          std::exp(-2e-4 * static_cast<double>(n)) * std::cos(0.13 * line * static_cast<double>(n));
    }
  }
  synth::signal::RealFft fft(samples.size());
  std::copy(samples.begin(), samples.end(), fft.signal().begin());
  fft.forward();
  const features::BinRange band{100, 9900};
  const auto whole = features::noise_floor(fft.spectrum(), band);
  const auto tail = features::tail_floor(samples, band);
  const double truth = 0.01 * static_cast<double>(samples.size());
  for (const std::size_t bin : {300, 2000, 5000, 9000}) {
    // The skirts of twenty lines are in the one, not in the other.
    EXPECT_GT(whole[bin], 0.7 * truth);
    EXPECT_NEAR(tail[bin] / truth, 1, 0.4) << bin;
  }
}

TEST(Sizes, AreTheLargestThatFftwLikes) {
  EXPECT_EQ(features::largest_fft_size(44100), 44100u);
  EXPECT_EQ(features::largest_fft_size(44099), 43904u);
  EXPECT_EQ(features::largest_fft_size(1), 0u);
  for (const std::size_t count : {97u, 1001u, 43968u}) {
    const std::size_t size = features::largest_fft_size(count);
    EXPECT_LE(size, count);
    EXPECT_GT(size, 0.9 * count);
    EXPECT_EQ(synth::signal::good_fft_size(size), size);
  }
}

}  // namespace
}  // namespace carillon::eval
