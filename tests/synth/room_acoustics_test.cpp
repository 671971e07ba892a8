#include "synth/room/room_acoustics.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "core/error.hpp"

namespace carillon::synth {
namespace {

/// Attenuation [dB/km] of ISO 9613-2:1996, table 2 (computed there by ISO 9613-1), octaves 125 Hz
/// to 8 kHz; one decimal below 10, no digit beyond three.
struct TabulatedAir {
  room::Air air;
  std::array<double, 7> decibels_per_km;
};

TEST(AirAbsorption, IsThatOfIso9613) {
  const TabulatedAir rows[] = {{{10, 0.7}, {0.4, 1.0, 1.9, 3.7, 9.7, 32.8, 117}},
                               {{20, 0.7}, {0.3, 1.1, 2.8, 5.0, 9.0, 22.9, 76.6}},
                               {{30, 0.7}, {0.3, 1.0, 3.1, 7.4, 12.7, 23.1, 59.3}},
                               {{15, 0.2}, {0.6, 1.2, 2.7, 8.2, 28.2, 88.8, 202}},
                               {{15, 0.5}, {0.5, 1.2, 2.2, 4.2, 10.8, 36.2, 129}},
                               {{15, 0.8}, {0.3, 1.1, 2.4, 4.1, 8.3, 23.7, 82.8}}};
  for (const TabulatedAir& row : rows) {
    for (std::size_t b = 0; b < 7; ++b) {
      // The table is of exact octave centres, 1000 * 10^(0.3 k).
      const double exact = 1000 * std::pow(10, 0.3 * (static_cast<double>(b) - 3));
      const double found =
          room::air_absorption(exact, row.air) * 10 * std::log10(std::exp(1.0)) * 1000;
      EXPECT_NEAR(found, row.decibels_per_km[b], std::max(0.055, 0.006 * found))
          << row.air.temperature << " C, " << room::octave_centres[b] << " Hz";
    }
  }
}

// 6 x 5 x 3 m, absorption 0.1, m = 5.8e-3 /m: 0.94 s. The wrong sign would give 1.30 s.
TEST(Eyring, AirShortensReverberation) {
  const Eigen::Vector3d size(6, 5, 3);
  room::OctaveValues absorption;
  absorption.fill(0.1);
  const room::Air air;
  const room::OctaveValues times = room::eyring(size, absorption, air);
  const double v = 90;
  const double s = 126;
  for (std::size_t b = 0; b < room::octave_count; ++b) {
    const double m = room::air_absorption(room::octave_centres[b], air);
    EXPECT_NEAR(times[b], 55.262 / 343 * v / (s * 0.105361 + 4 * m * v), 1e-4);
    EXPECT_LT(times[b], 55.262 / 343 * v / (s * 0.105360));
  }
  EXPECT_NEAR(times[0], 1.092, 0.005);
}

TEST(Eyring, WallsThatAbsorbAllLeaveNoReverberation) {
  room::OctaveValues all;
  all.fill(1);
  for (const double t : room::eyring({5, 4, 3}, all, room::Air{})) EXPECT_EQ(t, 0);
}

RC_GTEST_PROP(Eyring, IsInvertedExactly, ()) {
  const auto side = [] { return *rc::gen::inRange(1, 10000) / 100.0; };
  const Eigen::Vector3d size(side(), side(), side());
  room::OctaveValues absorption;
  for (double& a : absorption) a = *rc::gen::inRange(0, 990) / 1000.0;
  const room::Air air{static_cast<double>(*rc::gen::inRange(-20, 51)),
                      *rc::gen::inRange(0, 101) / 100.0};
  const room::OctaveValues found =
      room::absorption_for(size, room::eyring(size, absorption, air), air);
  for (std::size_t b = 0; b < room::octave_count; ++b) {
    RC_ASSERT(std::abs(found[b] - absorption[b]) < 1e-7);
  }
}

TEST(Eyring, ImpossibleTimesNameTheirBandsAndLimits) {
  room::OctaveValues times;
  times.fill(0.3);
  times[7] = 0.9;   // air alone: 0.48 s
  times[2] = 1e-3;  // absorption above 0.99
  try {
    room::absorption_for({5, 4, 3}, times, room::Air{});
    FAIL();
  } catch (const core::InputError& e) {
    EXPECT_NE(e.message().find("5 x 4 x 3 m"), std::string::npos) << e.what();
    EXPECT_NE(e.message().find("16000 Hz: 0.9 s is longer than the 0.4"), std::string::npos)
        << e.what();
    EXPECT_NE(e.message().find("500 Hz: 0.001 s is not within 0.022"), std::string::npos)
        << e.what();
    EXPECT_EQ(e.message().find("1000 Hz"), std::string::npos) << e.what();
    EXPECT_FALSE(e.hint().empty());
  }
  // Bands that do not exist at the sample rate are not asked about.
  times[2] = 0.3;
  EXPECT_NO_THROW(room::absorption_for({5, 4, 3}, times, room::Air{}, 7));
}

TEST(MeanAbsorption, IsWeightedByArea) {
  room::WallAbsorption walls = room::same_on_all_walls({});
  walls[4].fill(0.5);  // floor, 5 x 4 of 94 m^2
  EXPECT_NEAR(room::mean_absorption({5, 4, 3}, walls)[3], 0.5 * 20 / 94, 1e-15);
  walls = room::same_on_all_walls({});
  walls[0].fill(0.5);  // x = 0, 4 x 3
  EXPECT_NEAR(room::mean_absorption({5, 4, 3}, walls)[3], 0.5 * 12 / 94, 1e-15);
}

TEST(RoomAcoustics, RefusesWhatIsNoRoom) {
  room::OctaveValues a{};
  EXPECT_THROW(room::eyring({0, 4, 3}, a, room::Air{}), core::InputError);
  EXPECT_THROW(room::eyring({5, std::nan(""), 3}, a, room::Air{}), core::InputError);
  EXPECT_THROW(room::eyring({5, 4, INFINITY}, a, room::Air{}), core::InputError);
  EXPECT_THROW(room::eyring({5, 4, 3}, a, (room::Air{20, 1.1})), core::InputError);
  EXPECT_THROW(room::eyring({5, 4, 3}, a, (room::Air{300, 0.5})), core::InputError);
  a[3] = 1.01;
  EXPECT_THROW(room::eyring({5, 4, 3}, a, room::Air{}), core::InputError);
}

}  // namespace
}  // namespace carillon::synth
