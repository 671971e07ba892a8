#include "synth/radiation/modal_pressure.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "synth/modal/modal_response.hpp"
#include "synth/modal/ring_down.hpp"
#include "synth/signal/real_fft.hpp"

namespace carillon::synth {
namespace {

using Complex = std::complex<double>;

constexpr double audio_rate = 44100;

/// A dipole small against the wavelength, heard at r: P(s) = A (1/r + s/c) per acceleration.
constexpr double distance = 0.5;
Complex dipole(Complex s) {
  return 1.0 / distance + s / modal::speed_of_sound;
}

solvers::modes::Modes mode_of(double omega) {
  solvers::modes::Modes modes;
  modes.eigenvalues = {omega * omega};
  return modes;
}

modal::RingDown dipole_rings(double omega, double decay) {
  radiation::ModalPressure pressure;
  pressure.pressure = Eigen::MatrixXcd::Constant(1, 1, dipole({0, omega}));
  pressure.delays = {0.0};
  return {{omega * omega},
          {decay},
          Eigen::VectorXd::Ones(1),
          radiation::pressure_readout(pressure, mode_of(omega), std::vector<double>{decay})};
}

double peak(std::span<const float> sound) {
  double maximum = 0;
  for (const float value : sound) maximum = std::max(maximum, std::abs(double(value)));
  return maximum;
}

/// Pressure by Fourier transforms alone: force, oscillator and dipole at every frequency.
std::vector<double> in_frequencies(double omega, double decay, double contact, std::size_t count) {
  signal::RealFft fft(1 << 18);
  std::fill(fft.signal().begin(), fft.signal().end(), 0.0);
  for (std::size_t n = 0; double(n) / audio_rate < contact; ++n) {
    fft.signal()[n] =
        (1 - std::cos(2 * std::numbers::pi * double(n) / audio_rate / contact)) / contact;
  }
  fft.forward();
  for (std::size_t k = 0; k < fft.bins(); ++k) {
    const Complex s(0, 2 * std::numbers::pi * double(k) * audio_rate / double(fft.size()));
    fft.spectrum()[k] *= dipole(s) * s * s / (s * s + 2 * decay * s + omega * omega);
  }
  fft.inverse();
  return {fft.signal().begin(), fft.signal().begin() + std::ptrdiff_t(count)};
}

// A finger's long, soft push: the body follows it almost as if at rest, and what little pressure
// there is goes with the second and third derivative of the force.
TEST(ModalPressure, SlowPushesAreAsFaintAsADipoleMakesThem) {
  const double omega = 2 * std::numbers::pi * 900;
  for (const double decay : {5.0, 60.0}) {
    for (const double contact : {14e-3, 5e-3}) {
      const modal::RingDown rings = dipole_rings(omega, decay);
      const auto sound = modal::synthesize(rings, {contact}, audio_rate, 2000);
      const auto expected = in_frequencies(omega, decay, contact, 2000);
      double worst = 0, maximum = 0;
      for (std::size_t n = 0; n < expected.size(); ++n) {
        worst = std::max(worst, std::abs(double(sound[n]) - expected[n]));
        maximum = std::max(maximum, std::abs(expected[n]));
      }
      EXPECT_LT(worst, 0.02 * maximum) << decay << " " << contact;
      // As velocity alone it would be louder by far.
      modal::RingDown wrong = rings;
      wrong.readout.force_rate.setZero();
      EXPECT_GT(peak(modal::synthesize(wrong, {contact}, audio_rate, 2000)), 2 * maximum);
    }
  }
}

// The free decay of a lightly damped mode is that of the complex pressure.
TEST(ModalPressure, RingsAsTheComplexPressureSays) {
  const double omega = 2 * std::numbers::pi * 900;
  const double decay = 1e-3 * omega;
  const auto readout = dipole_rings(omega, decay).readout;
  const Complex s(-decay, std::sqrt(omega * omega - decay * decay));
  const Complex gain = s * (readout.velocity(0, 0) + s * readout.acceleration(0, 0));
  EXPECT_LT(std::abs(gain - dipole({0, omega}) * s * s), 2e-3 * std::abs(gain));
  // Of a dipole the continued transfer function is the dipole's own, at any damping.
  EXPECT_LT(std::abs(gain - dipole(s) * s * s), 1e-12 * std::abs(gain));
}

// Pressure goes on evenly through critical damping and stays in proportion beyond it.
TEST(ModalPressure, IsContinuousThroughCriticalDamping) {
  const double omega = 2 * std::numbers::pi * 900;
  for (const double contact : {0.0, 1e-4, 1e-3, 1e-2}) {
    const auto heard = [&](double ratio) {
      return modal::synthesize(dipole_rings(omega, ratio * omega), {contact}, audio_rate, 1000);
    };
    const double before = peak(heard(0.9));
    for (const double ratio : {0.99, 0.9999, 1 - 1e-8, 1.0, 1 + 1e-8, 1.0001, 1.1}) {
      EXPECT_NEAR(peak(heard(ratio)) / before, 1, 0.6) << ratio << " " << contact;
    }
    EXPECT_NEAR(peak(heard(1 - 1e-9)) / peak(heard(1 + 1e-9)), 1, 1e-5) << contact;
    EXPECT_LT(peak(heard(100)), 200 * before) << contact;
  }
}

TEST(ModalPressure, OfAModeWithoutStiffnessGoesWithTheAcceleration) {
  radiation::ModalPressure pressure;
  pressure.pressure = Eigen::MatrixXcd::Constant(1, 1, {2, 0});
  pressure.delays = {0.0};
  const modal::Readout readout =
      radiation::pressure_readout(pressure, mode_of(0), std::vector<double>{3.0});
  EXPECT_EQ(readout.acceleration(0, 0), 2);
  EXPECT_EQ(readout.velocity(0, 0), 0);
  EXPECT_EQ(readout.force_rate(0, 0), 0);
}

TEST(ModalPressure, ShareOfSlowForcesRisesFromNoneToAll) {
  EXPECT_EQ(modal::slow_fraction(1000, 0), 0);
  EXPECT_EQ(modal::slow_fraction(0, 1e-3), 0);
  EXPECT_NEAR(modal::slow_fraction(1000, 2e-3 * std::numbers::pi), 0.5, 1e-12);
  EXPECT_GT(modal::slow_fraction(1000, 0.1), 1 - 1e-9);
}

}  // namespace
}  // namespace carillon::synth
