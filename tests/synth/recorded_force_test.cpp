#include "synth/contact/recorded_force.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <vector>

#include "core/error.hpp"
#include "synth/modal/sampled_force.hpp"

namespace carillon::synth {
namespace {

// After a half sine sin(p t), p = pi / T, an undamped mode moves with the velocity
// Re[exp(i w t) p (1 + exp(-i w T)) / (p^2 - w^2)].
TEST(RecordedForce, DrivesAModeAsAHalfSineDoes) {
  constexpr double contact = 5e-4;
  const double p = std::numbers::pi / contact;
  const double omega = 2 * std::numbers::pi * 2200;
  const double t = 7.3e-4;
  const std::complex<double> i(0, 1);
  const double expected =
      std::real(std::exp(i * (omega * t)) * p * (1.0 + std::exp(-i * (omega * contact))) /
                (p * p - omega * omega));
  for (const int pieces : {24, 96}) {  // at 48 and 192 kHz
    std::vector<double> newtons;
    for (int k = 0; k <= pieces; ++k) newtons.push_back(std::sin(std::numbers::pi * k / pieces));
    newtons.back() = 0;
    const modal::ContactForce force = contact::recorded_force(newtons, pieces / contact);
    EXPECT_NEAR(force.duration, contact, 1e-15);
    const modal::SampledResponse mode(omega * omega, 0, force);
    // Lines take sinc^2(w h / 2) of the spectrum, and its images at multiples of the rate 1 / h add
    // (w^2 - p^2) h^2 / 12: together 1 - p^2 h^2 / 12, up to (w h)^4.
    const double lost = std::pow(p * contact / pieces, 2) / 12;
    EXPECT_NEAR(mode.at(t).velocity / expected, 1 - lost, 0.1 * lost) << pieces;
  }
}

TEST(RecordedForce, ComesFromNothingAndGoesThere) {
  const modal::ContactForce one = contact::recorded_force(std::vector<double>{3}, 1000);
  EXPECT_EQ(one.samples, (std::vector<double>{0, 3, 0}));
  EXPECT_DOUBLE_EQ(one.duration, 2e-3);
  EXPECT_DOUBLE_EQ(modal::impulse_of(one), 3e-3);
  const modal::ContactForce whole = contact::recorded_force(std::vector<double>{0, 2, -1, 0}, 1000);
  EXPECT_EQ(whole.samples, (std::vector<double>{0, 2, -1, 0}));
  EXPECT_DOUBLE_EQ(modal::impulse_of(whole), 1e-3);
}

TEST(RecordedForce, SaysWhatIsWrong) {
  using Samples = std::vector<double>;
  for (const Samples& wrong :
       {Samples{}, Samples{0, 0, 0}, Samples{0, std::numeric_limits<double>::quiet_NaN()}}) {
    EXPECT_THROW(contact::recorded_force(wrong, 48000), core::InputError);
  }
  for (const double rate : {0.0, -1.0, std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(contact::recorded_force(Samples{1}, rate), core::InputError);
  }
  EXPECT_THROW(contact::recorded_force(Samples(6001, 1.0), 100), core::InputError);
  EXPECT_THROW(contact::read_force("none.wav", 1), core::FileError);
}

}  // namespace
}  // namespace carillon::synth
