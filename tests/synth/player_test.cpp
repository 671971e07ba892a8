#include "synth/live/player.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <thread>
#include <vector>

#include "core/error.hpp"
#include "tests/counted_memory.hpp"
#include "tests/synth/random_rings.hpp"

namespace carillon::synth {
namespace {

constexpr double player_rate = 44100;

void add_rings(live::Player& player, unsigned count, int modes, bool pressure) {
  for (unsigned i = 0; i < count; ++i) {
    const modal::RingDown rings = random_rings(modes, i, pressure);
    player.add_body(rings.eigenvalues, rings.decay_rates, rings.readout);
  }
}

// Frames of what the offline synthesis gives for each strike, delayed and added.
TEST(Player, PlaysTheOfflineSum) {
  constexpr std::size_t count = 4000;
  live::Player player(2, player_rate, 0.5);
  add_rings(player, 3, 30, true);
  std::vector<double> expected(2 * count, 0.0);
  for (unsigned i = 0; i < 9; ++i) {
    modal::RingDown rings = random_rings(30, i % 3, true);
    const double time = 0.0077 * i * (i % 2 == 0 ? 1 : 0.6);
    const modal::ContactForce force{1e-4 * i};
    player.strike(i % 3, rings.excitation, force, time);
    for (double& delay : rings.readout.delays) delay += time;
    const auto sound = modal::synthesize(rings, force, player_rate, count);
    for (std::size_t n = 0; n < count; ++n) {
      for (std::size_t r = 0; r < 2; ++r) {
        expected[2 * n + r] += 0.5 * double(sound[r * count + n]);
      }
    }
  }
  std::vector<float> frames(2 * count);
  player.play(std::span(frames).first(2 * 700));
  player.play(std::span(frames).subspan(2 * 700));
  double peak = 0, worst = 0;
  for (const double s : expected) peak = std::max(peak, std::abs(s));
  for (std::size_t n = 0; n < frames.size(); ++n) {
    worst = std::max(worst, std::abs(double(frames[n]) - expected[n]));
  }
  EXPECT_LT(worst, 1e-6 * peak);
  EXPECT_EQ(player.played().events, 9U);
  EXPECT_EQ(player.played().late, 0U);
}

// The thread that plays asks for no memory, whatever the events: 10,000 in a block among them.
TEST(Player, PlayingAllocatesNothing) {
  live::Player player(1, player_rate);
  add_rings(player, 4, 20, false);
  const modal::RingDown rings = random_rings(20, 1, false);
  std::vector<double> damped = rings.decay_rates;
  for (double& d : damped) d += 40;
  for (int i = 0; i < 10000; ++i) {
    player.strike(std::size_t(i % 4), rings.excitation, {1e-4}, 0.001 + 1e-7 * i);
  }
  for (int i = 0; i < 50; ++i) player.change(1, rings.eigenvalues, damped, 0.0005 * i);
  player.stop(0.2);
  std::vector<float> frames(512);
  const std::size_t before = test::allocated().times;
  for (int i = 0; i < 30; ++i) player.play(frames);
  EXPECT_EQ(test::allocated().times, before);
  EXPECT_EQ(player.played().events, 10051U);
  EXPECT_TRUE(player.played().stopped);
  EXPECT_EQ(frames.back(), 0);
}

// Events of several threads all arrive, while another one plays.
TEST(Player, TakesEventsFromManyThreads) {
  live::Player player(1, player_rate);
  add_rings(player, 4, 10, false);
  const modal::RingDown rings = random_rings(10, 1, false);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < 3; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 400; ++i) {
        if (i % 4 == 3) {
          player.change(t, rings.eigenvalues, rings.decay_rates);
        } else {
          player.strike(t, rings.excitation, {1e-4});
        }
      }
    });
  }
  std::vector<float> frames(64);
  while (player.played().events < 1200) player.play(frames);
  for (std::thread& thread : threads) thread.join();
  EXPECT_TRUE(std::all_of(frames.begin(), frames.end(), [](float s) { return std::isfinite(s); }));
}

TEST(Player, SaysWhatIsLateAndRefusesWhatCannotBe) {
  live::Player player(1, player_rate);
  add_rings(player, 1, 10, false);
  const modal::RingDown rings = random_rings(10, 0, false);
  std::vector<float> frames(4410);
  player.play(frames);
  player.strike(0, rings.excitation, {0}, 0.06);
  player.play(std::span(frames).first(64));
  EXPECT_EQ(player.played().late, 1U);
  EXPECT_NEAR(player.played().latest, 0.04, 1e-9);
  EXPECT_NE(frames[0], 0);
  EXPECT_THROW(player.strike(0, rings.excitation, {0}, -1), core::InputError);
  EXPECT_THROW(player.strike(0, rings.excitation, {0}, 1e9), core::InputError);
  EXPECT_THROW(player.strike(1, rings.excitation, {0}), core::InputError);
  EXPECT_THROW(player.change(0, {}, {}), core::InputError);
}

}  // namespace
}  // namespace carillon::synth
