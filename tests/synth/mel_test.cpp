#include "synth/signal/mel.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <string>
#include <utility>

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
  const std::pair<std::size_t, int> frames[] = {{0, 1}, {1836, 1}, {1837, 2}, {44100, 25}};
  for (const auto& [count, expected] : frames) {
    EXPECT_EQ(signal::mel_extent(count, {}).frames, expected) << count;
  }
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
  EXPECT_THROW(signal::mel_extent(10, {.hop = 0}), core::InputError);
  EXPECT_THROW(with([](auto& o) { o.resized_bands = 65; })(), core::InputError);
}

// Of 128 bands and 29 frames (an overlap of 25 %) 64 and 25: each new band is the mean of two, each
// new frame of 29/25 old ones.
TEST(MelSpectrogram, IsMadeSmallerByMeansOfWhatEachCellCovers) {
  signal::MelOptions options;
  options.hop = 1536;
  options.bands = 128;
  const std::vector<float> clip = two_decays();
  const std::vector<float> all = signal::MelSpectrogram(options)(clip);
  ASSERT_EQ(all.size(), 128u * 29u);
  options.resized_bands = 64;
  options.resized_frames = 25;
  const signal::MelExtent extent = signal::mel_extent(clip.size(), options);
  EXPECT_EQ(extent.bands, 64);
  EXPECT_EQ(extent.frames, 25);
  const std::vector<float> fewer = signal::MelSpectrogram(options)(clip);
  ASSERT_EQ(fewer.size(), 64u * 25u);
  for (std::size_t band = 0; band < 64; ++band) {
    double whole = 0, made = 0;
    for (std::size_t i = 0; i < 29; ++i)
      whole += all[2 * band * 29 + i] + all[(2 * band + 1) * 29 + i];
    for (std::size_t i = 0; i < 25; ++i) made += fewer[band * 25 + i];
    EXPECT_NEAR(made / 25, whole / 58, 1e-6 * whole / 58) << band;  // means stay
    const auto old = [&](std::size_t frame) {
      return (all[2 * band * 29 + frame] + all[(2 * band + 1) * 29 + frame]) / 2.0;
    };
    const double second = 25.0 / 29 * (21.0 / 25 * old(1) + 8.0 / 25 * old(2));
    EXPECT_NEAR(fewer[band * 25 + 1], second, 1e-6 * second) << band;
  }
  EXPECT_THROW(signal::MelSpectrogram{options}(std::span(clip).first(20000)), core::InputError);
}

TEST(MelBands, LieWhereATonesBandIsTheLoudest) {
  signal::MelOptions options;
  options.bands = 40;
  const std::vector<double> centers = signal::mel_band_centers(options);
  ASSERT_EQ(centers.size(), 40U);
  // Slaney's scale: 27.5 mel or 2205 Hz and so on, of 41 equal steps up to that of 22,050 Hz.
  const double step = (15 + 27 * std::log(22.05) / std::log(6.4)) / 41;
  EXPECT_NEAR(centers[0], step * 200 / 3, 1e-9);
  EXPECT_NEAR(centers[39],
              1000 * std::exp((40 - 1 - (15 - step) / step) * step * std::log(6.4) / 27), 1e-6);
  const signal::MelSpectrogram mel(options);
  for (const std::size_t band : {9U, 20U, 33U}) {
    std::vector<float> clip(8192);
    for (std::size_t n = 0; n < clip.size(); ++n)
      clip[n] =
          static_cast<float>(std::sin(2 * pi * centers[band] * static_cast<double>(n) / 44100));
    const std::vector<float> cells = mel(clip);
    const std::size_t frames = cells.size() / 40;
    std::size_t loudest = 0;
    for (std::size_t b = 0; b < 40; ++b)
      if (cells[b * frames + 2] > cells[loudest * frames + 2]) loudest = b;
    EXPECT_EQ(loudest, band);
  }
  options.resized_bands = 20;
  const std::vector<double> fewer = signal::mel_band_centers(options);
  ASSERT_EQ(fewer.size(), 20U);
  EXPECT_NEAR(fewer[3], (centers[6] + centers[7]) / 2, 1e-9);
}

TEST(MelFrames, LieWhereAClicksFrameIsTheLoudest) {
  signal::MelOptions options;
  options.hop = 1024;
  const std::vector<double> centers = signal::mel_frame_centers(20480, options);
  ASSERT_EQ(centers.size(), 21U);
  for (const std::size_t frame : {0U, 7U, 19U}) {
    std::vector<float> clip(20480);
    clip[static_cast<std::size_t>(std::lround(centers[frame] * 44100))] = 1;
    const std::vector<float> cells = signal::MelSpectrogram(options)(clip);
    const auto row = cells.begin() + 20 * 21;
    EXPECT_EQ(std::max_element(row, row + 21) - row, static_cast<std::ptrdiff_t>(frame));
  }
  options.resized_frames = 7;
  const std::vector<double> fewer = signal::mel_frame_centers(20480, options);
  ASSERT_EQ(fewer.size(), 7U);
  EXPECT_NEAR(fewer[2], centers[7], 1e-12);  // of the frames 6, 7 and 8
}

TEST(MelSpectrogram, RefusesBandsThatHoldNoBinAndNamesWhatIsResolved) {
  signal::MelOptions options;
  options.fft_size = 512;
  options.bands = 128;
  // The closed form of Slaney's linear part: a bin each 86 Hz, triangles of 62 Hz below 1 kHz.
  const int empty = signal::empty_mel_bands(options);
  EXPECT_GT(empty, 0);
  try {
    signal::MelSpectrogram mel(options);
    FAIL() << "bands without a bin were taken";
  } catch (const core::InputError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find(std::to_string(empty) + " of 128 bands hold no bin of an FFT of 512"),
              std::string::npos)
        << text;
  }
  // What the message names is the border.
  for (int bands = 1; bands <= 128; ++bands) {
    options.bands = bands;
    const std::string named = signal::resolved_mel_bands(options);
    if (signal::empty_mel_bands(options) == 0) {
      const signal::MelSpectrogram mel(options);
      for (std::size_t band = 0; band < static_cast<std::size_t>(bands); ++band) {
        const auto first = mel.filters().begin() + static_cast<std::ptrdiff_t>(257 * band);
        EXPECT_GT(*std::max_element(first, first + 257), 0) << band << " of " << bands;
      }
    } else {
      int most = 0, size = 0;
      ASSERT_EQ(std::sscanf(named.c_str(), "at most %d bands, or an FFT of %d", &most, &size), 2);
      options.bands = most;
      EXPECT_EQ(signal::empty_mel_bands(options), 0) << named;
      options.bands = bands;
      options.fft_size = size;
      EXPECT_EQ(signal::empty_mel_bands(options), 0) << named;
      options.fft_size = size / 2;
      EXPECT_GT(signal::empty_mel_bands(options), 0) << named;
      options.fft_size = 512;
    }
  }
}

}  // namespace
}  // namespace carillon::synth
