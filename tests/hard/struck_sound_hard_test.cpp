// Strikers and the acceleration click where numbers leave the ordinary.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "core/error.hpp"
#include "synth/contact/acceleration_click.hpp"
#include "synth/contact/noise_burst.hpp"
#include "synth/contact/striker.hpp"
#include "synth/modal/ring_down.hpp"

namespace carillon::synth {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

contact::Striker ball() {
  return {"ball", 0.02, 0.008, 2e11, 0.29, 0.7, ""};
}
contact::StruckBody block() {
  return {0.3, 7e10, 0.2, 0};
}
contact::RigidSource sphere(double radius, double mass) {
  return {Vec3::Zero(), Eigen::Matrix3d::Identity(), Vec3::Constant(radius), mass};
}

modal::RingDown ringing(int modes, double gain, const std::string& unit) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit_interval(0, 1);
  modal::RingDown rings;
  rings.excitation = Eigen::VectorXd::Zero(modes);
  rings.readout.velocity = Eigen::MatrixXd::Constant(1, modes, gain);
  for (int i = 0; i < modes; ++i) {
    const double omega = 2 * std::numbers::pi * 50 * std::pow(400.0, unit_interval(random));
    rings.eigenvalues.push_back(omega * omega);
    rings.decay_rates.push_back((6 + 1e-7 * omega * omega) / 2);
    rings.excitation[i] = std::pow(10, -4 * unit_interval(random));
  }
  rings.readout.delays = {0.0};
  rings.readout.unit = unit;
  return rings;
}

bool finite(const std::vector<float>& samples) {
  for (const float value : samples) {
    if (!std::isfinite(value)) return false;
  }
  return true;
}

double peak(const std::vector<float>& samples) {
  double largest = 0;
  for (const float p : samples) largest = std::max(largest, std::abs(static_cast<double>(p)));
  return largest;
}

TEST(StrikerHard, SpeedsFromNothingToAbsurd) {
  const contact::HertzContact still = contact::hertz_contact(ball(), block(), 0);
  EXPECT_EQ(still.impulse, 0);
  EXPECT_EQ(still.duration, 0);
  double last = infinite;
  for (const double speed : {1e-300, 1e-12, 1.0, 1e12, 1e150}) {
    const contact::HertzContact contact = contact::hertz_contact(ball(), block(), speed);
    EXPECT_GT(contact.duration, 0) << speed;
    EXPECT_LT(contact.duration, last) << speed;
    EXPECT_TRUE(std::isfinite(contact.impulse) && contact.impulse > 0) << speed;
    EXPECT_FALSE(std::isnan(contact.peak_force));
    last = contact.duration;
  }
  EXPECT_THROW(contact::hertz_contact(ball(), block(), infinite), core::InputError);
}

TEST(StrikerHard, InfinitelyStiffAndInfinitelySoft) {
  contact::Striker rigid = ball();
  rigid.youngs_modulus = infinite;
  // One elastic side is enough for a finite contact.
  const double finite = contact::hertz_contact(rigid, block(), 1).duration;
  EXPECT_GT(finite, 0);
  EXPECT_LT(finite, contact::hertz_contact(ball(), block(), 1).duration);
  contact::StruckBody wall = block();
  wall.youngs_modulus = infinite;
  const contact::HertzContact both = contact::hertz_contact(rigid, wall, 1);
  EXPECT_EQ(both.duration, 0);
  EXPECT_GT(both.impulse, 0);
  contact::Striker soft = ball();
  soft.youngs_modulus = 1e-30;
  EXPECT_GT(contact::hertz_contact(soft, block(), 1).duration, 1e6);
  soft.youngs_modulus = 0;
  EXPECT_THROW(contact::hertz_contact(soft, block(), 1), core::InputError);
}

TEST(StrikerHard, AStrikerAMillionTimesHeavier) {
  contact::Striker heavy = ball();
  heavy.mass = block().mass * 1e6;
  const contact::HertzContact contact = contact::hertz_contact(heavy, block(), 1);
  EXPECT_NEAR(contact.mass / block().mass, 1, 2e-6);
  EXPECT_NEAR(contact.impulse / (block().mass * 1.7), 1, 2e-6);
  heavy.mass = infinite;
  EXPECT_NEAR(contact::hertz_contact(heavy, block(), 1).mass, block().mass, 1e-15);
  contact::StruckBody held = block();
  held.mass = infinite;
  EXPECT_THROW(contact::hertz_contact(heavy, held, 1), core::InputError);
}

TEST(StrikerHard, AHollowTighterThanTheStriker) {
  contact::StruckBody hollow = block();
  hollow.curvature = -1e9;
  EXPECT_NEAR(contact::hertz_contact(ball(), hollow, 1).radius, 0.08, 1e-12);
  hollow.curvature = infinite;
  EXPECT_THROW(contact::hertz_contact(ball(), hollow, 1), core::InputError);
}

TEST(NoiseBurstHard, OfOneSample) {
  core::RandomStream random(1, 2, "burst");
  const modal::ContactForce force = contact::noise_burst({1, 0}, 100, random);
  ASSERT_EQ(force.samples.size(), 4u);
  EXPECT_EQ(force.samples[0], 0);
  EXPECT_NE(force.samples[1], 0);
  EXPECT_EQ(force.samples[2], 0);
  modal::RingDown rings = ringing(20, 1, "m/s");
  EXPECT_TRUE(finite(modal::synthesize(rings, force, 44100, 4410)));
}

TEST(NoiseBurstHard, AtEveryEndOfItsRanges) {
  for (const double hardness : {0.0, 1.0}) {
    for (const double size : {0.0, 1.0}) {
      for (const double rate : {1000.0, 1001.0, 44100.0, 384000.0}) {
        core::RandomStream random(1, 2, "burst");
        const modal::ContactForce force = contact::noise_burst({hardness, size}, rate, random);
        double largest = 0;
        for (const double f : force.samples) largest = std::max(largest, std::abs(f));
        EXPECT_GT(largest, 0);
        EXPECT_LT(largest, 1e6);
      }
    }
  }
}

TEST(ClickHard, ForcesOfAnySize) {
  const auto make = [](double impulse, double duration) {
    return contact::acceleration_click(sphere(0.03, 0.1), {0, 0, impulse}, {.duration = duration},
                                       {0, 0, 1}, 44100, 2000);
  };
  const double one = peak(make(1, 1e-4));
  // Peak forces of 1e-12 and 1e12 N over 0.1 ms.
  EXPECT_NEAR(peak(make(5e-17, 1e-4)) / (5e-17 * one), 1, 1e-5);
  EXPECT_NEAR(peak(make(5e7, 1e-4)) / (5e7 * one), 1, 1e-5);
  EXPECT_EQ(peak(make(0, 1e-4)), 0);
  EXPECT_THROW(make(1e40, 1e-4), core::InputError);
  EXPECT_THROW(make(infinite, 1e-4), core::InputError);
  for (const double duration : {0.0, 1e-300, 1e-9, 1.0, 1e9}) {
    EXPECT_TRUE(finite(make(1, duration))) << duration;
  }
  EXPECT_LT(peak(make(1, 1e9)), 1e-9);
}

TEST(ClickHard, ABodyOfAMillimetreAndOneOfTenMetres) {
  for (const double radius : {0.0005, 5.0}) {
    for (const double duration : {0.0, 1e-6, 1e-3}) {
      const auto click = contact::acceleration_click(
          sphere(radius, 1), {0, 0, 1}, {.duration = duration}, {0, 0, 3 * radius}, 44100, 30000);
      EXPECT_TRUE(finite(click));
      EXPECT_GT(peak(click), 0);
      double sum = 0;
      for (const float p : click) sum += static_cast<double>(p) / 44100;
      // The potential of the motion that remains; 0.5 s hold both clicks whole.
      const double mass = 1 + 1.204 * 2 * std::numbers::pi / 3 * std::pow(radius, 3);
      EXPECT_NEAR(sum / (1.204 * radius / 18 / mass), 1, 1e-3) << radius << ' ' << duration;
    }
  }
}

TEST(ClickHard, AListenerOnTheSurface) {
  const auto click = contact::acceleration_click(sphere(0.03, 0.1), {0, 0, 1}, {.duration = 1e-4},
                                                 {0, 0, 0.03}, 44100, 500);
  EXPECT_TRUE(finite(click));
  EXPECT_EQ(click[0], 0.0f);  // the force begins at 0
  EXPECT_GT(click[1], 0.0f);
  EXPECT_THROW(contact::acceleration_click(sphere(0.03, 0.1), {0, 0, 1}, {.duration = 1e-4},
                                           {0, 0, 0.0299}, 44100, 500),
               core::InputError);
}

}  // namespace
}  // namespace carillon::synth
