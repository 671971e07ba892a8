#include "synth/room/reverberant_tail.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "synth/room/detail/reverberation_time.hpp"
#include "synth/room/room.hpp"

namespace carillon::synth {
namespace {

room::RoomOptions room(const Eigen::Vector3d& size, const room::OctaveValues& rt60) {
  room::RoomOptions options;
  options.size = size;
  options.source = size.cwiseProduct(Eigen::Vector3d(0.31, 0.27, 0.4));
  options.listener = size.cwiseProduct(Eigen::Vector3d(0.6, 0.66, 0.53));
  options.walls = room::same_on_all_walls(room::absorption_for(size, rt60, options.air));
  options.count = 66150;
  return options;
}

/// The tail after its images: from there on it is alone.
std::vector<double> alone(const room::RoomOptions& options) {
  const room::TailPlan plan = room::room_tail_plan(options);
  const auto tail = room::room_response(options).tail;
  const double start = plan.start + plan.step * static_cast<double>(plan.fill.size());
  return {tail.begin() + static_cast<std::ptrdiff_t>(std::ceil(start * options.sample_rate)),
          tail.end()};
}

struct Case {
  Eigen::Vector3d size;
  room::OctaveValues rt60;
};

// Several rooms and seeds, flat and steep in frequency: every single tail, in every octave.
TEST(ReverberantTail, HasThePrescribedTimeInEveryOctave) {
  const Case cases[] = {{{5, 4, 3}, {0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.4}},
                        {{10, 7.5, 3.5}, {1.2, 1.1, 1.0, 1.0, 1.0, 0.9, 0.7, 0.4}},
                        {{8, 6, 2.7}, {0.4, 0.5, 0.7, 0.8, 0.7, 0.5, 0.4, 0.3}}};
  constexpr int seeds = 20;
  for (const Case& c : cases) {
    room::OctaveValues mean{};
    for (int seed = 0; seed < seeds; ++seed) {
      room::RoomOptions options = room(c.size, c.rt60);
      options.seed = static_cast<std::uint64_t>(seed);
      const auto tail = alone(options);
      for (std::size_t b = 0; b < room::octave_count; ++b) {
        const auto found = room::reverberation_time(
            room::octave_band(tail, 44100, room::octave_centres[b]), 44100);
        ASSERT_TRUE(found.has_value()) << room::size_text(c.size) << " " << room::octave_centres[b];
        const double error = found->rt60 / c.rt60[b] - 1;
        mean[b] += error / seeds;
        EXPECT_LT(std::abs(error), 0.05)
            << room::size_text(c.size) << " " << room::octave_centres[b] << " Hz, seed " << seed;
      }
    }
    for (std::size_t b = 0; b < room::octave_count; ++b) {
      EXPECT_LT(std::abs(mean[b]), 0.02) << room::size_text(c.size) << " " << b;
    }
  }
}

double energy(const std::vector<double>& h, double from, double to, double rate) {
  double sum = 0;
  const auto end = std::min(h.size(), static_cast<std::size_t>(to * rate));
  for (auto n = static_cast<std::size_t>(from * rate); n < end; ++n) sum += h[n] * h[n];
  return sum;
}

// Energy of images alone in the 10 ms before the join (from their list, so that arrivals which
// coincide do not count twice), and of images and tail in the 10 ms after it.
TEST(ReverberantTail, TheJoinIsEvenToADecibel) {
  for (const Eigen::Vector3d& size : {Eigen::Vector3d(5, 4, 3), Eigen::Vector3d(10, 7.5, 3.5),
                                      Eigen::Vector3d(8, 6, 2.7), Eigen::Vector3d(4, 3.5, 2.5)}) {
    constexpr int seeds = 5;
    for (int seed = 0; seed < seeds; ++seed) {
      room::RoomOptions options = room(size, {0.6, 0.6, 0.6, 0.6, 0.6, 0.6, 0.6, 0.45});
      options.seed = static_cast<std::uint64_t>(seed);
      const room::TailPlan plan = room::room_tail_plan(options);
      const double matched = std::min(0.01, plan.start);
      const room::RoomResponse response = room::room_response(options);
      double before = 0, after = energy(response.tail, plan.start, plan.start + 0.01, 44100);
      const room::OctaveValues m = room::air_absorption(options.air);
      for (const room::ImageSource& image :
           room::image_sources(options.size, options.source, options.listener, options.order)) {
        const double time =
            (image.distance - plan.direct) / room::sound_speed(options.air) - plan.start;
        const room::OctaveValues gains = room::image_gains(image, plan.direct, options.walls, m);
        double power = 0;  // over the whole spectrum, octaves weighted by their width
        for (std::size_t b = 0; b < room::octave_count; ++b) {
          const double low = b == 0 ? 0 : room::lower_edge(b);
          const double high = b + 1 == room::octave_count ? 22050 : room::upper_edge(b);
          power += gains[b] * gains[b] * (high - low) / 22050;
        }
        if (time >= -matched && time < 0) before += power;
        if (time >= 0 && time < 0.01) after += power;
      }
      EXPECT_NEAR(10 * std::log10(after / before * matched / 0.01) + 60 * 0.01 / 0.55, 0, 1.0)
          << room::size_text(size) << " seed " << seed;
    }
  }
}

// Energy of images and tail together against the diffuse field's 4 pi c r0^2 / V T / (6 ln 10) from
// the tail's start on, averaged over places.
TEST(ReverberantTail, HasTheEnergyOfADiffuseField) {
  double mean = 0;
  int count = 0;
  for (const double x : {0.15, 0.3, 0.42}) {
    for (const double y : {0.2, 0.37}) {
      room::RoomOptions options = room({7, 6, 5}, {0.8, 0.8, 0.8, 0.8, 0.8, 0.8, 0.7, 0.4});
      options.source = options.size.cwiseProduct(Eigen::Vector3d(x, y, 0.4));
      const room::TailPlan plan = room::room_tail_plan(options);
      mean += plan.level[3];
      ++count;
      const double diffuse = 4 * M_PI * 343 * plan.direct * plan.direct / 210 *
                             std::exp(-6 * std::log(10.0) / 0.8 * (plan.direct / 343 + plan.start));
      EXPECT_NEAR(plan.power[3] / (diffuse * plan.level[3]), 1, 0.03);
    }
  }
  EXPECT_NEAR(10 * std::log10(mean / count), 0, 1.5);
}

TEST(ReverberantTail, IsTheSameForEqualKeysOnly) {
  room::RoomOptions options = room({5, 4, 3}, {0.3, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3});
  const auto first = room::room_response(options).tail;
  EXPECT_EQ(first, room::room_response(options).tail);
  room::RoomOptions other = options;
  other.seed = 1;
  EXPECT_NE(first, room::room_response(other).tail);
  other = options;
  other.listener.x() += 0.01;
  EXPECT_NE(first, room::room_response(other).tail);
}

TEST(ReverberantTail, IsSilentBeforeItsStart) {
  const room::RoomOptions options = room({5, 4, 3}, {0.3, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3});
  const room::RoomResponse response = room::room_response(options);
  EXPECT_GT(response.tail_start, 0.005);
  for (std::size_t n = 0; static_cast<double>(n) < response.tail_start * 44100; ++n) {
    ASSERT_EQ(response.tail[n], 0) << n;
  }
}

}  // namespace
}  // namespace carillon::synth
