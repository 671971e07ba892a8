#include "synth/room/image_sources.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>

#include "core/error.hpp"
#include "synth/modal/readout.hpp"

namespace carillon::synth {
namespace {

using Eigen::Vector3d;

const Vector3d room_size(5, 4, 3);
const Vector3d source_position(1, 1.25, 1);
const Vector3d hearer(2, 2.5, 1.5);

struct Expected {
  Vector3d position;
  std::array<int, room::wall_count> hits;
};

// Mirrored by hand in x = 0, x = 5, y = 0, y = 4, z = 0, z = 3.
const Expected hand_list[] = {
    {{-1, 1.25, 1}, {1, 0, 0, 0, 0, 0}},  {{9, 1.25, 1}, {0, 1, 0, 0, 0, 0}},
    {{1, -1.25, 1}, {0, 0, 1, 0, 0, 0}},  {{1, 6.75, 1}, {0, 0, 0, 1, 0, 0}},
    {{1, 1.25, -1}, {0, 0, 0, 0, 1, 0}},  {{1, 1.25, 5}, {0, 0, 0, 0, 0, 1}},
    {{11, 1.25, 1}, {1, 1, 0, 0, 0, 0}},  {{-9, 1.25, 1}, {1, 1, 0, 0, 0, 0}},
    {{1, 9.25, 1}, {0, 0, 1, 1, 0, 0}},   {{1, -6.75, 1}, {0, 0, 1, 1, 0, 0}},
    {{1, 1.25, 7}, {0, 0, 0, 0, 1, 1}},   {{1, 1.25, -5}, {0, 0, 0, 0, 1, 1}},
    {{-1, -1.25, 1}, {1, 0, 1, 0, 0, 0}}, {{-1, 6.75, 1}, {1, 0, 0, 1, 0, 0}},
    {{9, -1.25, 1}, {0, 1, 1, 0, 0, 0}},  {{9, 6.75, 1}, {0, 1, 0, 1, 0, 0}},
    {{-1, 1.25, -1}, {1, 0, 0, 0, 1, 0}}, {{-1, 1.25, 5}, {1, 0, 0, 0, 0, 1}},
    {{9, 1.25, -1}, {0, 1, 0, 0, 1, 0}},  {{9, 1.25, 5}, {0, 1, 0, 0, 0, 1}},
    {{1, -1.25, -1}, {0, 0, 1, 0, 1, 0}}, {{1, -1.25, 5}, {0, 0, 1, 0, 0, 1}},
    {{1, 6.75, -1}, {0, 0, 0, 1, 1, 0}},  {{1, 6.75, 5}, {0, 0, 0, 1, 0, 1}}};

TEST(ImageSources, OfOrderTwoAreTheHandList) {
  const auto images = room::image_sources(room_size, source_position, hearer, 2);
  ASSERT_EQ(images.size(), std::size(hand_list));
  for (const Expected& expected : hand_list) {
    const auto found =
        std::find_if(images.begin(), images.end(), [&](const room::ImageSource& image) {
          return (image.position - expected.position).norm() < 1e-12;
        });
    ASSERT_NE(found, images.end()) << expected.position.transpose();
    EXPECT_EQ(found->hits, expected.hits) << expected.position.transpose();
    EXPECT_NEAR(found->distance, (expected.position - hearer).norm(), 1e-12);
  }
  EXPECT_TRUE(std::is_sorted(images.begin(), images.end(),
                             [](const auto& a, const auto& b) { return a.distance < b.distance; }));
}

// Allen and Berkley's sum in the form of Habets' RIR generator: images ((1 - 2q) s + 2 m L), walls
// b0^|m - q| b1^|m|, order |2m - q| summed over the axes; pressure b / (4 pi d).
RC_GTEST_PROP(ImageSources, AreAllenAndBerkleys, ()) {
  const auto at = [](double low, double high) {
    return low + (high - low) * *rc::gen::inRange(1, 1000) / 1000.0;
  };
  const Vector3d size(at(1, 9), at(1, 9), at(1, 9));
  const Vector3d source(at(0, size.x()), at(0, size.y()), at(0, size.z()));
  const Vector3d listener(at(0, size.x()), at(0, size.y()), at(0, size.z()));
  const double direct = (source - listener).norm();
  RC_PRE(direct > 1e-3);
  const int order = *rc::gen::inRange(0, 6);
  room::WallAbsorption walls;
  for (auto& wall : walls) wall.fill(at(0, 1));

  std::vector<std::pair<double, double>> expected;  // distance, pressure over the direct one's
  for (int mx = -order; mx <= order; ++mx)
    for (int my = -order; my <= order; ++my)
      for (int mz = -order; mz <= order; ++mz)
        for (int corner = 0; corner < 8; ++corner) {
          const int q = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
          const int sum = std::abs(2 * mx - q) + std::abs(2 * my - j) + std::abs(2 * mz - k);
          if (sum > order || sum == 0) continue;
          const Vector3d image((1 - 2 * q) * source.x() + 2 * mx * size.x(),
                               (1 - 2 * j) * source.y() + 2 * my * size.y(),
                               (1 - 2 * k) * source.z() + 2 * mz * size.z());
          const auto b = [&walls](int wall, int times) {
            return std::pow(std::sqrt(1 - walls[static_cast<std::size_t>(wall)][0]), times);
          };
          const double beta = b(0, std::abs(mx - q)) * b(1, std::abs(mx)) * b(2, std::abs(my - j)) *
                              b(3, std::abs(my)) * b(4, std::abs(mz - k)) * b(5, std::abs(mz));
          const double d = (image - listener).norm();
          expected.emplace_back(d, beta / (4 * M_PI * d) * (4 * M_PI * direct));
        }
  std::vector<std::pair<double, double>> found;
  for (const room::ImageSource& image : room::image_sources(size, source, listener, order)) {
    found.emplace_back(image.distance,
                       room::image_gains(image, direct, walls, room::OctaveValues{})[0]);
  }
  std::sort(expected.begin(), expected.end());
  std::sort(found.begin(), found.end());
  RC_ASSERT(found.size() == expected.size());
  double total_found = 0, total_expected = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    RC_ASSERT(std::abs(found[i].first - expected[i].first) < 1e-9);
    total_found += found[i].second * found[i].first;
    total_expected += expected[i].second * expected[i].first;
  }
  RC_ASSERT(std::abs(total_found - total_expected) < 1e-6 * (1 + total_expected));
}

TEST(ImageGains, AirTakesFromTheLongerWay) {
  room::ImageSource image;
  image.distance = 11;
  room::OctaveValues m{};
  m[5] = 0.02;
  const auto gains = room::image_gains(image, 1, room::same_on_all_walls({}), m);
  EXPECT_NEAR(gains[0], 1.0 / 11, 1e-15);
  EXPECT_NEAR(gains[5] * gains[5], std::exp(-0.02 * 10) / 121, 1e-15);
}

/// Level [dB] and delay [samples] of a kernel at a frequency in cycles per sample.
std::pair<double, double> level_and_delay(const std::vector<double>& weights, std::size_t first,
                                          double frequency) {
  std::complex<double> h = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    // Around the delay, where the phase does not wrap.
    h += weights[i] * std::polar(1.0, -2 * M_PI * frequency * static_cast<double>(i));
  }
  const double middle = static_cast<double>(weights.size() / 2);
  const double phase = std::arg(h * std::polar(1.0, 2 * M_PI * frequency * middle));
  return {20 * std::log10(std::abs(h)),
          static_cast<double>(first) + middle - phase / (2 * M_PI * frequency)};
}

TEST(FractionalDelay, IsExactToAHundredthOfASample) {
  for (const double delay : {40.0, 57.25, 100.5, 1234.567, 99999.999}) {
    const room::DelayKernel kernel = room::fractional_delay(delay);
    EXPECT_LE(kernel.weights.size(), 81U);
    for (const double frequency : {0.001, 0.1, 0.25, 0.4, 0.44}) {
      const auto [level, found] = level_and_delay(kernel.weights, kernel.first, frequency);
      EXPECT_NEAR(level, 0, 0.01) << delay << " " << frequency;
      EXPECT_NEAR(found, delay, 0.01) << delay << " " << frequency;
    }
  }
}

TEST(FractionalDelay, NothingIsThereBeforeTheDirectSound) {
  for (double delay = 0; delay < 45; delay += 0.13) {
    const room::DelayKernel kernel = room::fractional_delay(delay);
    double sum = 0, moment = 0;
    for (std::size_t i = 0; i < kernel.weights.size(); ++i) {
      sum += kernel.weights[i];
      moment += kernel.weights[i] * static_cast<double>(kernel.first + i);
      EXPECT_TRUE(std::isfinite(kernel.weights[i]));
    }
    EXPECT_NEAR(sum, 1, 1e-12);
    EXPECT_NEAR(moment, delay, 0.15) << delay;  // delay at low frequencies
    if (delay >= 40) {
      EXPECT_EQ(kernel.first, static_cast<std::size_t>(std::ceil(delay - 40)));
    }
  }
}

TEST(ImageResponse, ArrivesWithTheLevelAndDelayOfFreeField) {
  // One image, no loss but distance: 1/r against the direct sound, (r - r0) / c later.
  room::WallAbsorption walls = room::same_on_all_walls({});
  room::ImageSource image;
  image.distance = 7.3;
  image.hits = {1, 0, 0, 0, 0, 0};
  const double rate = 44100;
  const room::Air dry{20, 0.5};
  const auto response = room::image_response(std::span(&image, 1), 2.0, walls, dry, rate, 2000,
                                             room::ReflectionFilters(rate));
  const double delay = (7.3 - 2.0) / modal::speed_of_sound * rate;
  const auto from = static_cast<std::size_t>(delay) - 60;
  const std::vector<double> part(response.begin() + static_cast<std::ptrdiff_t>(from),
                                 response.begin() + static_cast<std::ptrdiff_t>(from) + 121);
  for (const double frequency : {500.0, 1000.0}) {  // air takes less than 0.03 dB
    const auto [level, found] = level_and_delay(part, from, frequency / rate);
    EXPECT_NEAR(level, 20 * std::log10(2.0 / 7.3), 0.03) << frequency;
    // What air takes from the highest octaves is taken by a causal filter, which delays a little.
    EXPECT_NEAR(found, delay, 0.2) << frequency;
  }
  for (std::size_t n = 0; n + 45 < static_cast<std::size_t>(delay); ++n) {
    ASSERT_LT(std::abs(response[n]), 1e-6) << n;
  }
}

TEST(ReflectionFilters, KeepTheEnergyOfEveryOctave) {
  const double rate = 44100;
  const room::ReflectionFilters filters(rate);
  const std::size_t bins = filters.fft_size() / 2 + 1;
  const room::OctaveValues cases[] = {{0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2},
                                      {0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5},
                                      {0.3, 0.9, 0.3, 0.9, 0.3, 0.9, 0.3, 0.9},
                                      {1e-3, 2e-3, 2e-3, 2e-3, 1e-3, 5e-4, 5e-4, 1e-3}};
  for (const room::OctaveValues& gains : cases) {
    std::vector<std::complex<double>> spectrum(bins, 1.0);
    filters.apply(gains, spectrum);
    for (std::size_t b = 0; b < room::octave_count; ++b) {
      double energy = 0, count = 0;
      for (std::size_t k = 0; k < bins; ++k) {
        const double f = static_cast<double>(k) * rate / static_cast<double>(filters.fft_size());
        if (f < room::lower_edge(b) || f > room::upper_edge(b)) continue;
        energy += std::norm(spectrum[k]);
        ++count;
      }
      // A filter of 46 ms has four bins in the lowest octave: they are a coarse mean.
      EXPECT_NEAR(10 * std::log10(energy / count / (gains[b] * gains[b])), 0, b < 2 ? 1.0 : 0.3)
          << b;
    }
  }
}

TEST(ReflectionFilters, AreFlatForEqualGainsAndSilentForNone) {
  const room::ReflectionFilters filters(16000);
  EXPECT_EQ(filters.octaves(), 7U);  // the octave of 16 kHz begins at 11.3 kHz
  std::vector<std::complex<double>> spectrum(filters.fft_size() / 2 + 1, {2, 1});
  room::OctaveValues gains;
  gains.fill(0.25);
  filters.apply(gains, spectrum);
  for (const auto& h : spectrum) EXPECT_NEAR(std::abs(h - std::complex(0.5, 0.25)), 0, 1e-9);
  filters.apply(room::OctaveValues{}, spectrum);
  for (const auto& h : spectrum) EXPECT_EQ(h, 0.0);
}

TEST(CheckRoom, NamesWhatIsOutside) {
  const auto message = [](const Vector3d& source, const Vector3d& listener) -> std::string {
    try {
      room::check_room(room_size, source, listener, 3);
    } catch (const core::InputError& e) {
      EXPECT_FALSE(e.hint().empty());
      return e.message();
    }
    return "";
  };
  EXPECT_EQ(message(source_position, hearer), "");
  EXPECT_EQ(message({6, 1, 1}, hearer),
            "the source at (6, 1, 1) m is not inside the room of 5 x 4 x 3 m");
  EXPECT_EQ(message({5, 1, 1}, hearer),
            "the source at (5, 1, 1) m is not inside the room of 5 x 4 x 3 m");
  EXPECT_EQ(message(source_position, {1, -1, 1}),
            "the listener at (1, -1, 1) m is not inside the room of 5 x 4 x 3 m");
  EXPECT_EQ(message(source_position, {1, 1, std::nan("")}),
            "the listener at (1, 1, nan) m is not inside the room of 5 x 4 x 3 m");
  EXPECT_EQ(message(source_position, source_position),
            "source and listener are both at (1, 1.25, 1) m");
  EXPECT_THROW(room::check_room(room_size, source_position, hearer, -1), core::InputError);
  EXPECT_THROW(room::check_room(room_size, source_position, hearer, 21), core::InputError);
}

}  // namespace
}  // namespace carillon::synth
