#include "synth/room/room.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <filesystem>
#include <fstream>

#include "core/error.hpp"
#include "core/hdf5.hpp"
#include "core/temporary_folder.hpp"
#include "synth/room/detail/reverberation_time.hpp"
#include "synth/signal/convolution.hpp"

namespace carillon::synth {
namespace {

room::RoomOptions furnished() {
  room::RoomOptions options;
  room::OctaveValues absorption = {0.1, 0.15, 0.2, 0.25, 0.3, 0.3, 0.3, 0.35};
  options.walls = room::same_on_all_walls(absorption);
  return options;
}

TEST(RoomResponse, WallsThatAbsorbEverythingAreTheFreeField) {
  room::RoomOptions options;
  room::OctaveValues all;
  all.fill(1);
  options.walls = room::same_on_all_walls(all);
  const room::RoomResponse response = room::room_response(options);
  EXPECT_TRUE(response.images.empty());
  EXPECT_TRUE(response.tail.empty());
  EXPECT_LT(response.tail_db, room::inaudible_tail);
}

TEST(RoomResponse, AVeryAbsorbentRoomHasNoTail) {
  room::RoomOptions options;
  room::OctaveValues much;
  much.fill(0.98);
  options.walls = room::same_on_all_walls(much);
  options.listener = {1.2, 1, 1};
  const room::RoomResponse response = room::room_response(options);
  EXPECT_FALSE(response.images.empty());
  EXPECT_LT(response.tail_db, -60);
  EXPECT_TRUE(response.tail.empty());
}

TEST(RoomResponse, WithoutImagesTheTailBeginsWithTheFirstReflection) {
  room::RoomOptions options = furnished();
  options.order = 0;
  const room::RoomResponse response = room::room_response(options);
  EXPECT_TRUE(response.images.empty());
  const double first =
      room::image_sources(options.size, options.source, options.listener, 1)[0].distance;
  EXPECT_NEAR(response.tail_start, (first - (options.source - options.listener).norm()) / 343,
              1e-12);
  EXPECT_FALSE(response.tail.empty());
}

// Acceptance of the field: images to a high order decay between Eyring's time and 1.6 times it.
TEST(RoomResponse, ImagesAloneDecayByEyringOrSlower) {
  room::RoomOptions options;
  options.size = {3, 4, 2.5};
  options.source = {0.9, 1.1, 1.3};
  options.listener = {2.2, 2.9, 1.2};
  room::OctaveValues absorption;
  absorption.fill(0.6);
  options.walls = room::same_on_all_walls(absorption);
  options.order = 14;
  options.sample_rate = 16000;
  options.count = 3000;
  const room::RoomResponse response = room::room_response(options);
  const auto found = room::reverberation_time(response.images, 16000, 20);
  ASSERT_TRUE(found.has_value());
  EXPECT_GT(found->rt60, 0.95 * response.rt60[3]);
  EXPECT_LT(found->rt60, 1.6 * response.rt60[3]);
}

// Source and listener change places: the same lengths of ways, the same images.
TEST(RoomResponse, ImagesAreReciprocal) {
  room::RoomOptions options = furnished();
  const auto there = room::room_response(options).images;
  std::swap(options.source, options.listener);
  const auto back = room::room_response(options).images;
  ASSERT_EQ(there.size(), back.size());
  for (std::size_t n = 0; n < there.size(); ++n) ASSERT_NEAR(there[n], back[n], 1e-9);
}

TEST(RoomResponse, PartsAreTheSameApart) {
  room::RoomOptions options = furnished();
  const room::RoomResponse both = room::room_response(options);
  options.with_tail = false;
  EXPECT_EQ(room::room_response(options).images, both.images);
  EXPECT_TRUE(room::room_response(options).tail.empty());
  options.with_tail = true;
  options.with_images = false;
  EXPECT_EQ(room::room_response(options).tail, both.tail);
  EXPECT_TRUE(room::room_response(options).images.empty());
}

// 100 m in a room of 1 km: the direct sound has lost what ISO 9613-1 says, at every frequency.
TEST(RoomResponse, AirDullsTheDirectSound) {
  room::RoomOptions options = furnished();
  options.size = {1000, 1000, 1000};
  options.source = {450, 500, 500};
  options.listener = {550, 500, 500};
  options.with_images = options.with_tail = false;
  const std::vector<double> air = room::room_response(options).air;
  for (const double f : {125.0, 1000.0, 4000.0, 8000.0}) {
    std::complex<double> sum = 0;
    for (std::size_t n = 0; n < air.size(); ++n) {
      sum += air[n] * std::polar(1.0, -2 * M_PI * f * static_cast<double>(n) / 44100);
    }
    const double expected = -10 / std::log(10.0) * room::air_absorption(f, options.air) * 100;
    EXPECT_NEAR(20 * std::log10(std::abs(sum)), expected, 0.05) << f;
  }
  options.listener = options.source + Eigen::Vector3d(0.01, 0, 0);
  EXPECT_TRUE(room::room_response(options).air.empty());
}

// Images and tail together in a plain room (even absorption, no side much longer): T30 of the whole
// response, octaves wide enough for one response to speak for itself.
TEST(RoomResponse, WholeHasThePrescribedTime) {
  room::RoomOptions options = furnished();
  options.size = {6, 5, 4};
  options.source = {1.9, 1.4, 1.6};
  options.listener = {3.6, 3.3, 2.1};
  const room::OctaveValues times = {0.6, 0.6, 0.6, 0.6, 0.6, 0.6, 0.6, 0.4};
  options.walls = room::same_on_all_walls(room::absorption_for(options.size, times, options.air));
  const room::RoomResponse response = room::room_response(options);
  std::vector<double> whole(options.count, 0.0);
  for (std::size_t n = 0; n < response.images.size(); ++n) whole[n] += response.images[n];
  for (std::size_t n = 0; n < response.tail.size(); ++n) whole[n] += response.tail[n];
  whole[0] += 1;
  for (std::size_t b = 0; b < room::octave_count; ++b) {
    const auto found =
        room::reverberation_time(room::octave_band(whole, 44100, room::octave_centres[b]), 44100);
    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR(found->rt60 / times[b], 1, 0.1) << room::octave_centres[b];
  }
}

TEST(RoomResponse, EndsWithTheClip) {
  room::RoomOptions options = furnished();
  for (const std::size_t count : {0UL, 1UL, 100UL, 700UL, 20000UL}) {
    options.count = count;
    const room::RoomResponse response = room::room_response(options);
    EXPECT_LE(response.images.size(), count);
    EXPECT_LE(response.tail.size(), count);
  }
}

TEST(RoomResponse, WorksAtEverySampleRate) {
  for (const double rate : {8000.0, 16000.0, 22050.0, 48000.0, 96000.0, 192000.0}) {
    room::RoomOptions options = furnished();
    options.sample_rate = rate;
    options.count = static_cast<std::size_t>(rate / 4);
    const room::RoomResponse response = room::room_response(options);
    double energy = 0;
    for (const double v : response.tail) energy += v * v;
    for (const double v : response.images) ASSERT_TRUE(std::isfinite(v));
    ASSERT_TRUE(std::isfinite(energy));
    // The energy of a unit impulse's response does not depend on the rate but for what the upper
    // octaves lose.
    EXPECT_GT(energy, 0.1) << rate;
    EXPECT_LT(energy, 3) << rate;
  }
}

TEST(RoomResponse, RefusesPlacesOutside) {
  room::RoomOptions options = furnished();
  options.listener = {5.5, 2, 1};
  EXPECT_THROW(room::room_response(options), core::InputError);
  options = furnished();
  options.sample_rate = 0;
  EXPECT_THROW(room::room_response(options), core::InputError);
  options = furnished();
  options.walls[2][3] = 1.5;
  EXPECT_THROW(room::room_response(options), core::InputError);
}

TEST(RoomCache, GivesTheSameResponse) {
  const core::TemporaryFolder folder;
  const room::RoomOptions options = furnished();
  const room::RoomResponse computed = room::cached_room_response(options, folder.path());
  const auto path = folder / (room::room_key(options) + ".h5");
  ASSERT_TRUE(std::filesystem::exists(path));
  const auto written = std::filesystem::last_write_time(path);
  const room::RoomResponse read = room::cached_room_response(options, folder.path());
  EXPECT_EQ(std::filesystem::last_write_time(path), written);
  EXPECT_EQ(read.images, computed.images);
  EXPECT_EQ(read.tail, computed.tail);
  EXPECT_EQ(read.rt60, computed.rt60);
  EXPECT_EQ(read.level, computed.level);
  EXPECT_EQ(read.tail_db, computed.tail_db);
  EXPECT_EQ(read.tail_start, computed.tail_start);
}

TEST(RoomCache, ABrokenFileIsComputedAgain) {
  const core::TemporaryFolder folder;
  const room::RoomOptions options = furnished();
  const auto path = folder / (room::room_key(options) + ".h5");
  std::ofstream(path) << "no HDF5";
  const room::RoomResponse found = room::cached_room_response(options, folder.path());
  EXPECT_EQ(found.images, room::room_response(options).images);
}

TEST(RoomCache, EveryOptionCounts) {
  const room::RoomOptions options = furnished();
  std::vector<room::RoomOptions> others(9, options);
  others[0].size.x() += 1e-9;
  others[1].source.y() += 1e-9;
  others[2].listener.z() += 1e-9;
  others[3].walls[5][7] += 1e-9;
  others[4].air.humidity += 1e-9;
  others[5].order = 2;
  others[6].count -= 1;
  others[7].seed = 1;
  others[8].with_tail = false;
  for (const room::RoomOptions& other : others)
    EXPECT_NE(room::room_key(other), room::room_key(options));
}

}  // namespace
}  // namespace carillon::synth
