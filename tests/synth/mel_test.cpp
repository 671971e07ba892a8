#include "synth/signal/mel.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.hpp"

namespace carillon::synth {
namespace {

constexpr double pi = 3.14159265358979323846;

double sum_of(const std::vector<float>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

long non_zeros(const std::vector<float>& values) {
  return std::count_if(values.begin(), values.end(), [](float w) { return w != 0; });
}

/// 0.5 exp(-20 t) sin 2 pi 1000 t + 0.25 exp(-40 t) sin 2 pi 3456.7 t, one second at 44.1 kHz.
std::vector<float> two_decays() {
  std::vector<float> clip(44100);
  for (std::size_t n = 0; n < clip.size(); ++n) {
    const double t = static_cast<double>(n) / 44100;
    clip[n] = static_cast<float>(0.5 * std::exp(-20 * t) * std::sin(2 * pi * 1000 * t) +
                                 0.25 * std::exp(-40 * t) * std::sin(2 * pi * 3456.7 * t));
  }
  return clip;
}

// Reference figures of librosa's definition, computed with NumPy (double STFT, float32 filters).
TEST(MelFilters, AreLibrosas) {
  const signal::MelSpectrogram mel{signal::MelOptions{}};
  const auto& filters = mel.filters();
  ASSERT_EQ(filters.size(), 64u * 1025u);
  EXPECT_NEAR(sum_of(filters), 2.971802347, 1e-8);
  EXPECT_EQ(non_zeros(filters), 1982);
  const auto row = filters.begin() + 10 * 1025;
  const auto peak = std::max_element(row, row + 1025);
  EXPECT_EQ(peak - row, 31);
  EXPECT_NEAR(*peak, 0.0137932952, 1e-9);
}

TEST(MelFilters, AreLibrosasAtOtherRatesAndSizes) {
  signal::MelOptions options;
  options.sample_rate = 48000;
  const signal::MelSpectrogram faster(options);
  EXPECT_NEAR(sum_of(faster.filters()), 2.730023207, 1e-8);
  EXPECT_EQ(non_zeros(faster.filters()), 1980);
  options = {};
  options.fft_size = 1024;
  const signal::MelSpectrogram shorter(options);
  EXPECT_NEAR(sum_of(shorter.filters()), 1.484678806, 1e-8);
  EXPECT_EQ(non_zeros(shorter.filters()), 990);
}

// librosa's own documentation: filters.mel(sr=22050, n_fft=2048) has 0.016 at [0, 1].
TEST(MelFilters, MatchLibrosasDocumentation) {
  signal::MelOptions options;
  options.sample_rate = 22050;
  options.bands = 128;
  EXPECT_NEAR(signal::MelSpectrogram(options).filters()[1], 0.016, 5e-4);
}

TEST(MelFilters, HaveUnitAreaInHertz) {
  // Slaney's norm: each triangle's area is 1, up to its sampling at the FFT's bins.
  signal::MelOptions options;
  options.fft_size = 1 << 15;
  options.min_frequency = 200;
  options.max_frequency = 12000;
  const signal::MelSpectrogram mel(options);
  const std::size_t bins = mel.filters().size() / 64;
  for (std::size_t band = 0; band < 64; ++band) {
    double area = 0;
    for (std::size_t bin = 0; bin < bins; ++bin) area += mel.filters()[band * bins + bin];
    EXPECT_NEAR(area * 44100 / (1 << 15), 1, 1e-3) << band;
  }
}

TEST(MelSpectrogram, IsLibrosas) {
  const signal::MelSpectrogram mel{signal::MelOptions{}};
  const std::vector<float> power = mel(two_decays());
  ASSERT_EQ(power.size(), 64u * 25u);
  EXPECT_NEAR(sum_of(power), 1044.088879, 1e-5 * 1044);
  const auto peak = std::max_element(power.begin(), power.end());
  EXPECT_EQ(peak - power.begin(), 15 * 25);
  EXPECT_NEAR(*peak, 363.9136903, 1e-4);
  EXPECT_NEAR(power[0], 0.7477227375, 1e-6);
  EXPECT_NEAR(power[20 * 25 + 3], 1.579603373e-07, 1e-4 * 1.579603373e-07);
  // In dB below the peak with a floor at -80 dB.
  double sum = 0;
  int on_floor = 0;
  for (const float p : power) {
    const double level =
        10 * std::log10(std::max(1e-10, double(p))) - 10 * std::log10(double(*peak));
    sum += std::max(level, -80.0);
    on_floor += level <= -80 ? 1 : 0;
  }
  EXPECT_NEAR(sum / 1600, -77.28796173, 1e-6);
  EXPECT_NEAR(on_floor / 16.0, 92.0, 0.05);
}

TEST(MelSpectrogram, SecondCallAndEqualObjectsGiveTheSameBits) {
  const std::vector<float> clip = two_decays();
  const signal::MelSpectrogram mel{signal::MelOptions{}};
  const signal::MelSpectrogram other{signal::MelOptions{}};
  const std::vector<float> first = mel(clip);
  EXPECT_EQ(first, mel(clip));
  EXPECT_EQ(first, other(clip));
}

TEST(MelSpectrogram, ScalesWithPower) {
  const signal::MelSpectrogram mel{signal::MelOptions{}};
  std::vector<float> clip = two_decays();
  const std::vector<float> once = mel(clip);
  for (float& sample : clip) sample *= 4;
  const std::vector<float> loud = mel(clip);
  for (std::size_t i = 0; i < once.size(); ++i) EXPECT_EQ(loud[i], 16 * once[i]) << i;
}

TEST(MelSpectrogram, ShortAndEmptyClips) {
  const signal::MelSpectrogram mel{signal::MelOptions{}};
  EXPECT_EQ(signal::mel_frames(0, {}), 1);
  EXPECT_EQ(signal::mel_frames(1836, {}), 1);
  EXPECT_EQ(signal::mel_frames(1837, {}), 2);
  EXPECT_EQ(signal::mel_frames(44100, {}), 25);
  EXPECT_EQ(sum_of(mel(std::vector<float>{})), 0);
  // A single sample lies under the window's middle, where it is 1: a flat spectrum.
  const std::vector<float> power = mel(std::vector<float>{0.5f});
  ASSERT_EQ(power.size(), 64u);
  for (std::size_t band = 0; band < 64; ++band) {
    double area = 0;
    for (std::size_t bin = 0; bin < 1025; ++bin) area += mel.filters()[band * 1025 + bin];
    EXPECT_NEAR(power[band], 0.25 * area, 1e-6 * area);
  }
}

TEST(MelSpectrogram, RefusesImpossibleDefinitions) {
  const auto with = [](auto change) {
    signal::MelOptions options;
    change(options);
    return [options] { signal::MelSpectrogram mel(options); };
  };
  EXPECT_THROW(with([](auto& o) { o.hop = 0; })(), core::InputError);
  EXPECT_THROW(with([](auto& o) { o.fft_size = 1025; })(), core::InputError);
  EXPECT_THROW(with([](auto& o) { o.bands = 0; })(), core::InputError);
  EXPECT_THROW(with([](auto& o) { o.sample_rate = 0; })(), core::InputError);
  EXPECT_THROW(with([](auto& o) { o.max_frequency = 30000; })(), core::InputError);
  EXPECT_THROW(with([](auto& o) { o.min_frequency = 23000; })(), core::InputError);
  EXPECT_THROW(signal::mel_frames(10, {.hop = 0}), core::InputError);
}

}  // namespace
}  // namespace carillon::synth
