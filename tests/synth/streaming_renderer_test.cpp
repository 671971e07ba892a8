#include "synth/modal/streaming_renderer.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <type_traits>

#include "core/error.hpp"
#include "tests/counted_memory.hpp"
#include "tests/synth/random_rings.hpp"

namespace carillon::synth {
namespace {

constexpr double audio_rate = 44100;

struct PlannedStrike {
  std::size_t body;
  double time;
  double impulse;
  modal::ContactForce force;
};

/// Bodies of every kind: rising numbers of modes, and some near and beyond critical damping.
std::vector<modal::RingDown> bodies(bool pressure) {
  std::vector<modal::RingDown> all;
  for (unsigned i = 0; i < 3; ++i) {
    all.push_back(random_rings(7 + 20 * int(i), 40 + i, pressure));
    all[i].decay_rates[1] = std::sqrt(all[i].eigenvalues[1]) * (0.999 + 0.001 * i);
    all[i].decay_rates[2] = std::sqrt(all[i].eigenvalues[2]) * 1.7;
  }
  return all;
}

std::vector<float> stream(const std::vector<modal::RingDown>& all,
                          const std::vector<PlannedStrike>& strikes,
                          const std::vector<std::size_t>& sizes, std::size_t count) {
  const std::size_t rows = all[0].readout.delays.size();
  modal::StreamingRenderer renderer(rows, audio_rate);
  for (const modal::RingDown& rings : all) {
    renderer.add_body(rings.eigenvalues, rings.decay_rates, rings.readout);
  }
  std::vector<float> out(rows * count);
  std::vector<float> block;
  std::vector<bool> told(strikes.size());
  for (std::size_t done = 0, turn = 0; done < count; ++turn) {
    const std::size_t size = std::min(sizes[turn % sizes.size()], count - done);
    for (std::size_t b = 0; b < strikes.size(); ++b) {
      const double delay = strikes[b].time - double(done) / audio_rate;
      if (told[b] || delay * audio_rate > double(size) + 700) continue;
      told[b] = true;
      renderer.strike(strikes[b].body, all[strikes[b].body].excitation * strikes[b].impulse,
                      strikes[b].force, delay);
    }
    block.resize(rows * size);
    renderer.render(block);
    for (std::size_t r = 0; r < rows; ++r) {
      std::copy_n(block.begin() + std::ptrdiff_t(r * size), size,
                  out.begin() + std::ptrdiff_t(r * count + done));
    }
    done += size;
  }
  return out;
}

/// Every strike by synthesize(), its time as a delay, added up.
std::vector<double> offline(const std::vector<modal::RingDown>& all,
                            const std::vector<PlannedStrike>& strikes, std::size_t count) {
  std::vector<double> sum(all[0].readout.delays.size() * count, 0.0);
  for (const PlannedStrike& strike : strikes) {
    modal::RingDown rings = all[strike.body];
    rings.excitation *= strike.impulse;
    for (double& delay : rings.readout.delays) delay += strike.time;
    const auto sound = modal::synthesize(rings, strike.force, audio_rate, count);
    for (std::size_t n = 0; n < sum.size(); ++n) sum[n] += double(sound[n]);
  }
  return sum;
}

// Blocks of any size; strikes at any time, on bodies that ring, during contacts of others.
TEST(StreamingRenderer, IsTheOfflineSumTo120DecibelsWhateverTheBlocks) {
  constexpr std::size_t sample_count = 6000;
  modal::ContactForce burst{4e-3, {}};
  for (int i = 0; i < 150; ++i) burst.samples.push_back(300 * std::sin(i * i * 0.7));
  for (const bool pressure : {false, true}) {
    const auto all = bodies(pressure);
    const std::vector<PlannedStrike> strikes = {
        {0, 0, 1, {1e-3}},          {1, 0.00321, 0.4, {2e-4}}, {1, 0.00333, 0.7, {5e-3}},
        {2, 0.0301234, 1.3, burst}, {0, 0.0301234, 0.2, {0}},  {2, 0.0302, -0.5, {7e-4}}};
    const auto expected = offline(all, strikes, sample_count);
    double peak = 0;
    for (const double s : expected) peak = std::max(peak, std::abs(s));
    for (const std::vector<std::size_t>& sizes :
         {std::vector<std::size_t>{64}, {1}, {512}, {480}, {sample_count}, {3, 700, 1, 17}}) {
      const auto sound = stream(all, strikes, sizes, sample_count);
      double worst = 0;
      for (std::size_t n = 0; n < sound.size(); ++n) {
        worst = std::max(worst, std::abs(double(sound[n]) - expected[n]));
      }
      EXPECT_LT(worst, 1e-6 * peak) << sizes[0] << " " << pressure;
    }
  }
}

// A strike on a body that rings adds up: both at once are the sum of each alone.
TEST(StreamingRenderer, StrikesAddUp) {
  EXPECT_TRUE(rc::check("superposition", [] {
    const auto all = bodies(false);
    std::vector<PlannedStrike> strikes;
    const int count = *rc::gen::inRange(2, 6);
    for (int i = 0; i < count; ++i) {
      strikes.push_back({*rc::gen::element<std::size_t>(0, 1, 2),
                         1e-5 * *rc::gen::inRange(0, 4000),
                         0.1 * *rc::gen::inRange(-20, 20),
                         {1e-5 * *rc::gen::inRange(0, 300)}});
    }
    const std::vector<std::size_t> sizes = {std::size_t(*rc::gen::inRange(1, 900))};
    const auto together = stream(all, strikes, sizes, 3000);
    std::vector<double> sum(together.size(), 0.0);
    double peak = 0;
    for (const PlannedStrike& strike : strikes) {
      const auto alone = stream(all, {strike}, sizes, 3000);
      for (std::size_t n = 0; n < sum.size(); ++n) {
        sum[n] += double(alone[n]);
        peak = std::max(peak, std::abs(double(alone[n])));
      }
    }
    for (std::size_t n = 0; n < sum.size(); ++n) {
      RC_ASSERT(std::abs(sum[n] - double(together[n])) <= 1e-6 * peak);
    }
  }));
}

// Strikes one after the other are one strike, later and again.
TEST(StreamingRenderer, RepeatsAStrike) {
  const modal::RingDown rings = random_rings(20, 8, true);
  constexpr double interval = 0.0312345;
  const std::vector<double> times = {interval, 0, 2 * interval};
  const auto sound = modal::synthesize_strikes(rings, {1e-3}, times, audio_rate, 6000);
  std::vector<PlannedStrike> strikes;
  for (const double time : times) strikes.push_back({0, time, 1, {1e-3}});
  const auto expected = offline({rings}, strikes, 6000);
  double peak = 0;
  for (const double s : expected) peak = std::max(peak, std::abs(s));
  for (std::size_t n = 0; n < sound.size(); ++n) {
    ASSERT_NEAR(double(sound[n]), expected[n], 1e-6 * peak);
  }
}

// What rings points into its body: it may move, also as others join, but not be copied.
TEST(StreamingRenderer, RingsOnWhereItIsMoved) {
  static_assert(!std::is_copy_constructible_v<modal::StreamingRenderer>);
  static_assert(!std::is_copy_assignable_v<modal::StreamingRenderer>);
  const auto all = bodies(false);
  const auto sound = [&](bool moved) {
    modal::StreamingRenderer renderer(1, audio_rate);
    const auto add = [&](const modal::RingDown& rings) {
      renderer.add_body(rings.eigenvalues, rings.decay_rates, rings.readout);
    };
    if (!moved) {
      for (const modal::RingDown& rings : all) add(rings);
    } else {
      add(all[0]);
    }
    renderer.strike(0, all[0].excitation, {1e-3});
    std::vector<float> out(3000);
    renderer.render(std::span(out).first(1000));
    if (moved) {
      add(all[1]);
      add(all[2]);
      auto elsewhere = std::make_unique<modal::StreamingRenderer>(std::move(renderer));
      elsewhere->render(std::span(out).subspan(1000, 1000));
      modal::StreamingRenderer assigned(1, audio_rate);
      assigned = std::move(*elsewhere);
      elsewhere.reset();
      assigned.render(std::span(out).last(1000));
    } else {
      renderer.render(std::span(out).subspan(1000, 1000));
      renderer.render(std::span(out).last(1000));
    }
    return out;
  };
  EXPECT_EQ(sound(true), sound(false));
}

TEST(StreamingRenderer, SilenceCostsNothing) {
  const modal::RingDown rings = random_rings(60, 3, false);
  modal::StreamingRenderer renderer(1, audio_rate);
  renderer.add_body(rings.eigenvalues, rings.decay_rates, rings.readout);
  EXPECT_EQ(renderer.voices(), 0U);
  renderer.strike(0, rings.excitation, {1e-3});
  std::vector<float> block(512);
  renderer.render(block);
  EXPECT_EQ(renderer.voices(), 60U);
  // The slowest mode falls by 160 dB and its share in six seconds.
  for (int i = 0; i < 900; ++i) renderer.render(block);
  EXPECT_EQ(renderer.voices(), 0U);
  EXPECT_TRUE(std::all_of(block.begin(), block.end(), [](float s) { return s == 0; }));
}

// Strikes for ever: neither voices nor memory grow, and rendering allocates nothing.
TEST(StreamingRenderer, SteadyStateAllocatesNothing) {
  const auto all = bodies(true);
  modal::StreamingRenderer renderer(2, audio_rate);
  for (const modal::RingDown& rings : all) {
    renderer.add_body(rings.eigenvalues, rings.decay_rates, rings.readout);
  }
  std::vector<float> block(2 * 256);
  std::size_t maximum = 0;
  std::size_t before = 0;
  for (int i = 0; i < 400; ++i) {
    if (i == 50) before = test::allocated().times;
    renderer.strike(std::size_t(i % 3), all[std::size_t(i % 3)].excitation, {1.1e-3},
                    1e-5 * double(i % 7));
    renderer.render(block);
    maximum = std::max(maximum, renderer.voices());
  }
  EXPECT_EQ(test::allocated().times, before);
  std::size_t partials = 0;
  for (const modal::RingDown& rings : all) partials += 2 * (rings.eigenvalues.size() + 1);
  EXPECT_LE(maximum, partials);
}

TEST(StreamingRenderer, RefusesWhatCannotBe) {
  EXPECT_THROW(modal::StreamingRenderer(0, audio_rate), core::InputError);
  EXPECT_THROW(modal::StreamingRenderer(1, 0), core::InputError);
  modal::StreamingRenderer renderer(2, audio_rate);
  const modal::RingDown mono = random_rings(4, 1, false);
  const modal::RingDown rings = random_rings(4, 1, true);
  EXPECT_THROW(renderer.add_body(mono.eigenvalues, mono.decay_rates, mono.readout),
               core::InputError);
  EXPECT_THROW(renderer.add_body(rings.eigenvalues, {}, rings.readout), core::InputError);
  renderer.add_body(rings.eigenvalues, rings.decay_rates, rings.readout);
  EXPECT_THROW(renderer.strike(1, rings.excitation, {}), core::InputError);
  EXPECT_THROW(renderer.strike(0, Eigen::VectorXd::Ones(3), {}), core::InputError);
  EXPECT_THROW(renderer.strike(0, rings.excitation, {-1}), core::InputError);
  EXPECT_THROW(renderer.strike(0, rings.excitation, {}, -1), core::InputError);
  EXPECT_THROW(renderer.strike(0, rings.excitation, {}, std::nan("")), core::InputError);
  std::vector<float> odd(3);
  EXPECT_THROW(renderer.render(odd), core::InputError);
}

}  // namespace
}  // namespace carillon::synth
