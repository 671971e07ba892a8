#include <gtest/gtest.h>

#include <cmath>

#include "core/error.hpp"
#include "synth/room/detail/reverberation_time.hpp"
#include "synth/room/room.hpp"
#include "synth/signal/convolution.hpp"

namespace carillon::synth {
namespace {

room::RoomOptions room(double side, double absorption) {
  room::RoomOptions options;
  options.size = side * Eigen::Vector3d(1, 0.8, 0.6);
  options.source = side * Eigen::Vector3d(0.2, 0.25, 0.3);
  options.listener = side * Eigen::Vector3d(0.6, 0.5, 0.35);
  room::OctaveValues same;
  same.fill(absorption);
  options.walls = room::same_on_all_walls(same);
  return options;
}

double energy(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return sum;
}

void expect_finite(const room::RoomResponse& response) {
  for (const double v : response.images) ASSERT_TRUE(std::isfinite(v));
  for (const double v : response.tail) ASSERT_TRUE(std::isfinite(v));
}

// All reflections fall within two samples; a decay of a millisecond holds less than a period of the
// lower octaves. All images arrive in phase at low frequencies: the response's sum is theirs. The
// tail has no more energy than its octaves' prescribed decay.
TEST(HardRoom, OfACentimetre) {
  const room::RoomOptions options = room(0.01, 0.2);
  const room::RoomResponse response = room::room_response(options);
  expect_finite(response);
  EXPECT_LT(response.rt60[3], 0.002);
  EXPECT_LT(response.tail.size(), 200U);
  const double direct = (options.source - options.listener).norm();
  double expected = 0;
  for (const room::ImageSource& image :
       room::image_sources(options.size, options.source, options.listener, options.order)) {
    expected += direct / image.distance * std::pow(0.8, image.order / 2.0);
  }
  double sum = 0;
  for (const double v : response.images) sum += v;
  EXPECT_NEAR(sum / expected, 1, 0.01);
  EXPECT_LT(energy(response.images), expected * expected);
  EXPECT_LT(energy(response.tail), 2 * std::pow(10.0, response.tail_db / 10));
}

// Nothing comes back within a clip of one second; in a clip of 20 s it does.
TEST(HardRoom, OfAKilometre) {
  room::RoomOptions options = room(1000, 0.2);
  options.listener = options.source + Eigen::Vector3d(1, 0, 0);
  const room::RoomResponse silent = room::room_response(options);
  EXPECT_TRUE(silent.images.empty());
  EXPECT_TRUE(silent.tail.empty());
  options.count = 20 * 44100;
  options.walls = room(1000, 0.01).walls;
  const room::RoomResponse late = room::room_response(options);
  expect_finite(late);
  const double first =
      room::image_sources(options.size, options.source, options.listener, 1)[0].distance;
  EXPECT_GT(energy(late.images), 0);
  const auto begins = static_cast<std::size_t>((first - 1) / 343 * 44100) - 45;
  for (std::size_t n = 0; n < begins; ++n) ASSERT_LT(std::abs(late.images[n]), 1e-9) << n;
}

// Walls that absorb nothing: air alone ends it, after minutes in the lowest octave. The response is
// as long as the clip.
TEST(HardRoom, WithoutAbsorption) {
  room::RoomOptions options = room(5, 0);
  options.count = 5 * 44100;
  const room::RoomResponse response = room::room_response(options);
  expect_finite(response);
  EXPECT_GT(response.rt60[0], 100);
  EXPECT_EQ(response.tail.size(), options.count);
  options.air.humidity = 0;
  expect_finite(room::room_response(options));
}

// Octaves that are absorbed entirely beside octaves that are not at all.
TEST(HardRoom, OfAlternatingAbsorption) {
  room::RoomOptions options = room(5, 0);
  for (room::OctaveValues& wall : options.walls) wall = {0.3, 1, 0.3, 1, 0.3, 1, 0.3, 1};
  const room::RoomResponse response = room::room_response(options);
  expect_finite(response);
  EXPECT_EQ(response.rt60[1], 0);
  const auto open = room::octave_band(response.images, 44100, 500);
  const auto closed = room::octave_band(response.images, 44100, 1000);
  EXPECT_LT(10 * std::log10(energy(closed) / energy(open)), -15);
  EXPECT_LT(energy(room::octave_band(response.tail, 44100, 1000)),
            3e-2 * energy(room::octave_band(response.tail, 44100, 500)));
}

// One wall absorbs everything: images that do not meet it remain.
TEST(HardRoom, WithOneOpenWall) {
  room::RoomOptions options = room(5, 0.1);
  options.walls[5].fill(1);
  const room::RoomResponse response = room::room_response(options);
  expect_finite(response);
  EXPECT_GT(energy(response.images), 0);
  EXPECT_GT(response.rt60[3], 0.05);
}

TEST(HardRoom, ListenerANanometreFromTheSourceOrAWall) {
  room::RoomOptions options = room(5, 0.2);
  options.listener = options.source + Eigen::Vector3d(1e-9, 0, 0);
  const room::RoomResponse near = room::room_response(options);
  expect_finite(near);
  // Everything else is 180 dB below so near a direct sound: there is no tail to hear.
  EXPECT_LT(near.tail_db, -100);
  EXPECT_TRUE(near.tail.empty());
  options.listener = Eigen::Vector3d(1e-9, 2, 1);
  const room::RoomResponse at_wall = room::room_response(options);
  expect_finite(at_wall);
  // The first image is the direct sound again.
  EXPECT_NEAR(at_wall.images[0], std::sqrt(0.8), 0.1);
}

TEST(HardRoom, ListenerOnAWallOrOutsideIsRefused) {
  room::RoomOptions options = room(5, 0.2);
  for (const Eigen::Vector3d& place :
       {Eigen::Vector3d(0, 1, 1), Eigen::Vector3d(5, 1, 1), Eigen::Vector3d(-1, 1, 1),
        Eigen::Vector3d(INFINITY, 1, 1), Eigen::Vector3d(options.source)}) {
    options.listener = place;
    EXPECT_THROW(room::room_response(options), core::InputError) << place.transpose();
  }
}

TEST(HardRoom, OfNoSizeIsRefused) {
  for (const double side : {0.0, -1.0, 1e-200, 1e200, static_cast<double>(NAN)}) {
    room::RoomOptions options = room(5, 0.2);
    options.size.x() = side;
    EXPECT_THROW(room::room_response(options), core::InputError) << side;
  }
}

// A tunnel: sides of 1 : 1000. Eyring's time by hand, and the first wall's reflection at its time.
TEST(HardRoom, OfAThousandToOne) {
  room::RoomOptions options = room(1, 0.05);
  options.size = {1000, 1, 1};
  options.source = {500, 0.3, 0.4};
  options.listener = {503, 0.6, 0.7};
  const room::RoomResponse response = room::room_response(options);
  expect_finite(response);
  // 24 ln 10 / c = 0.16111 s/m; V = 1000 m3, S = 4002 m2; air takes nothing at 125 Hz.
  EXPECT_NEAR(response.rt60[0], 0.16111 * 1000 / (4002 * -std::log(0.95)), 0.01);
  const double direct = std::sqrt(9 + 0.09 + 0.09);
  // A wall at distances a and b of source and listener: r^2 = r0^2 + 4 a b, here a = 0.3, b = 0.6 m
  // (y0) or a = 0.6, b = 0.3 m (ceiling).
  const double nearest = std::sqrt(direct * direct + 4 * 0.3 * 0.6);
  EXPECT_NEAR(room::image_sources(options.size, options.source, options.listener, 1)[0].distance,
              nearest, 1e-9);
  const double level = direct / nearest * std::sqrt(0.95);
  EXPECT_GT(energy(response.images), level * level);
}

TEST(HardRoom, ClipsOfExtremesComeOutAsNumbers) {
  const room::RoomOptions options = room(5, 0.2);
  const room::RoomResponse response = room::room_response(options);
  signal::Convolver convolver;
  const auto spectrum = convolver.prepare(response.tail, 44100);
  for (const float peak : {1e-30F, 1e-12F, 1e12F, 1e30F}) {
    std::vector<float> clip(44100, 0.0F);
    clip[0] = peak;
    std::vector<float> wet = clip;
    convolver.add(clip, spectrum, wet);
    for (std::size_t n = 0; n < response.tail.size() && n < wet.size(); n += 97) {
      const double expected = static_cast<double>(peak) * response.tail[n] + (n == 0 ? peak : 0.0);
      ASSERT_NEAR(wet[n], expected, 1e-6 * static_cast<double>(peak)) << n;
    }
  }
}

}  // namespace
}  // namespace carillon::synth
