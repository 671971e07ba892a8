#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "core/error.hpp"
#include "synth/modal/ring_down.hpp"
#include "tests/synth/random_rings.hpp"

namespace carillon::synth {
namespace {

using Real = long double;
using Cplx = std::complex<long double>;
constexpr Real pi = std::numbers::pi_v<long double>;

modal::RingDown one_row(std::vector<double> lambda, std::vector<double> d,
                        std::vector<double> gains, bool pressure = false) {
  modal::RingDown rings;
  rings.excitation = Eigen::VectorXd::Ones(Eigen::Index(gains.size()));
  (pressure ? rings.readout.acceleration : rings.readout.velocity) =
      Eigen::Map<Eigen::RowVectorXd>(gains.data(), Eigen::Index(gains.size()));
  rings.eigenvalues = std::move(lambda);
  rings.decay_rates = std::move(d);
  rings.readout.delays = {0.0};
  return rings;
}

double peak_of(const std::vector<float>& samples) {
  double peak = 0;
  for (const float s : samples) peak = std::max(peak, std::abs(double(s)));
  return peak;
}

/// The plain sum over modes in extended precision, straight from the two poles.
std::vector<Real> plain_sum(const modal::RingDown& rings, Eigen::Index row, double contact_time,
                            double fs, std::size_t count) {
  std::vector<Real> out(count, 0);
  const bool pressure = rings.readout.acceleration.size() > 0;
  const Eigen::MatrixXd& gains = pressure ? rings.readout.acceleration : rings.readout.velocity;
  const Real omega_force = 2 * pi / Real(contact_time);
  for (std::size_t i = 0; i < rings.eigenvalues.size(); ++i) {
    const Real d = rings.decay_rates[i];
    const Real wd = std::sqrt(Real(rings.eigenvalues[i]) - d * d);
    const Cplx s(-d, wd);
    const auto integral = [&](Real t) {  // of force times exp(s (t - t')) from 0 to min(t, T)
      const Cplx down = (s * std::cos(omega_force * t) - omega_force * std::sin(omega_force * t)) /
                        (s * s + omega_force * omega_force);
      const Cplx up = s / (s * s + omega_force * omega_force);
      return ((std::exp(s * t) - Real(1)) / s - std::exp(s * t) * up + down) / Real(contact_time);
    };
    for (std::size_t n = 0; n < count; ++n) {
      const Real t = Real(n) / fs - rings.readout.delays[std::size_t(row)];
      if (t < 0) continue;
      Cplx value = contact_time == 0 ? std::exp(s * t)
                   : t < contact_time
                       ? integral(t)
                       : integral(contact_time) * std::exp(s * (t - Real(contact_time)));
      value *= s;
      Real force = 0;
      if (pressure) {
        value *= s;
        if (contact_time > 0 && t < contact_time) {
          force = (1 - std::cos(omega_force * t)) / Real(contact_time);
        }
      }
      out[n] += Real(gains(row, Eigen::Index(i))) * (value.imag() / wd + force);
    }
  }
  return out;
}

TEST(Synthesize, IsThePlainSumToFloatPrecision) {
  for (const bool pressure : {false, true}) {
    for (const double contact_time : {0.0, 3e-4, 2.3e-3}) {
      const modal::RingDown rings = random_rings(29, 5, pressure);
      constexpr std::size_t sample_count = 8000;
      const std::vector<float> sound =
          modal::synthesize(rings, {contact_time}, 44100, sample_count);
      ASSERT_EQ(sound.size(), sample_count * rings.readout.delays.size());
      for (std::size_t row = 0; row < rings.readout.delays.size(); ++row) {
        const auto expected =
            plain_sum(rings, Eigen::Index(row), contact_time, 44100, sample_count);
        double peak = 0, worst = 0;
        for (std::size_t n = 0; n < sample_count; ++n) {
          peak = std::max(peak, std::abs(double(expected[n])));
          // Rounding to float apart, the tails left out stay below -140 dB.
          const double error =
              std::abs(double(sound[row * sample_count + n]) - double(expected[n])) -
              0x1p-24 * std::abs(double(expected[n]));
          worst = std::max(worst, error);
        }
        EXPECT_LT(worst, 1e-7 * peak) << contact_time << " " << pressure << " row " << row;
        EXPECT_GT(peak, 0);
      }
    }
  }
}

// Everything the kernel does in one sound: partials in contact, tails left out, several seconds;
// -120 dB of the peak against the plain sum in extended precision.
TEST(Synthesize, MatchesThePlainSumTo120Decibels) {
  for (const int modes : {1, 60}) {
    for (const double contact_time : {0.0, 4e-3}) {
      const modal::RingDown rings = random_rings(modes, 17, false);
      constexpr std::size_t sample_count = 30000;
      const auto expected = plain_sum(rings, 0, contact_time, 44100, sample_count);
      double peak = 0;
      for (const Real s : expected) peak = std::max(peak, std::abs(double(s)));
      const auto sound = modal::synthesize(rings, {contact_time}, 44100, sample_count);
      double worst = 0;
      for (std::size_t n = 0; n < sample_count; ++n) {
        worst = std::max(worst, std::abs(double(sound[n]) - double(expected[n])));
      }
      EXPECT_LT(worst, 1e-6 * peak) << modes << " " << contact_time;
    }
  }
}

// Modes that have died away end, and what they could still have added stays within the bound.
TEST(Synthesize, EndsInaudibleModes) {
  modal::RingDown rings = random_rings(40, 21, false);
  for (double& d : rings.decay_rates) d *= 20;
  constexpr std::size_t sample_count = 40000;
  const auto exact = plain_sum(rings, 0, 1e-3, 44100, sample_count);
  const auto sound = modal::synthesize(rings, {1e-3}, 44100, sample_count);
  EXPECT_NE(exact.back(), 0);
  EXPECT_EQ(sound[sample_count - 1], 0);
  double worst = 0, peak = 0;
  for (std::size_t n = sample_count / 2; n < sample_count; ++n) {
    worst = std::max(worst, std::abs(double(sound[n]) - double(exact[n])));
  }
  for (const Real value : exact) peak = std::max(peak, std::abs(double(value)));
  EXPECT_LE(worst, modal::inaudible * peak + 1e-7 * peak);
  EXPECT_GT(worst, 0);
}

// Where the contact stops being written as partials (modes near the pulse's frequency, slow ones),
// nothing jumps and neither side loses digits.
TEST(Synthesize, ContactIsAccurateOnBothSidesOfTheSplit) {
  constexpr double contact = 5e-3;
  for (const double angle :
       {0.00999, 0.01001, 0.5, 2 * std::numbers::pi - 0.01001, 2 * std::numbers::pi - 0.00999,
        2 * std::numbers::pi, 2 * std::numbers::pi + 0.00999, 2 * std::numbers::pi + 0.01001}) {
    for (const double d : {0.0, 0.5}) {
      const double omega = angle / contact;
      modal::RingDown rings = one_row({omega * omega + d * d}, {d}, {1});
      const auto expected = plain_sum(rings, 0, contact, 44100, 1000);
      double peak = 0, worst = 0;
      const auto sound = modal::synthesize(rings, {contact}, 44100, 1000);
      for (std::size_t n = 0; n < 1000; ++n) {
        peak = std::max(peak, std::abs(double(expected[n])));
        worst = std::max(worst, std::abs(double(sound[n]) - double(expected[n])));
      }
      // The plain sum itself divides by zero at resonance.
      if (angle != 2 * std::numbers::pi || d > 0) {
        EXPECT_LT(worst, 1e-7 * peak) << angle << " " << d;
      }
      for (const float s : sound) ASSERT_TRUE(std::isfinite(s));
    }
  }
}

TEST(Synthesize, StartsWithTheImpulsesVelocity) {
  // v(0+) = sum of gains: J phi^2 / m for every mode.
  const modal::RingDown rings = random_rings(20, 3, false);
  EXPECT_NEAR(modal::synthesize(rings, {0}, 44100, 1)[0], rings.readout.velocity.sum(), 1e-6);
}

TEST(Synthesize, ShortContactTendsToAnIdealImpulse) {
  const modal::RingDown rings = random_rings(20, 4, false);
  const auto ideal = modal::synthesize(rings, {0}, 44100, 4000);
  double last = 1;
  for (const double contact_time : {1e-5, 1e-6, 1e-7, 1e-8}) {
    const auto soft = modal::synthesize(rings, {contact_time}, 44100, 4000);
    double worst = 0;
    for (std::size_t n = 1; n < ideal.size(); ++n) {
      worst = std::max(worst, std::abs(double(soft[n]) - ideal[n]));
    }
    worst /= peak_of(ideal);
    EXPECT_LT(worst, 0.2 * last) << contact_time;
    last = worst;
  }
  EXPECT_LT(last, 1e-3);
}

TEST(Synthesize, IsLinearInTheImpulse) {
  modal::RingDown rings = random_rings(20, 8, true);
  const auto once = modal::synthesize(rings, {1e-3}, 44100, 5000);
  rings.readout.acceleration *= 2;
  const auto twice = modal::synthesize(rings, {1e-3}, 44100, 5000);
  for (std::size_t n = 0; n < once.size(); ++n) ASSERT_EQ(twice[n], 2 * once[n]) << n;
}

TEST(Synthesize, LeavesOutModesFromNyquistOn) {
  const double nyquist = 2 * std::numbers::pi * 22050;
  const auto with = [&](double omega, double d) {
    const modal::RingDown rings = one_row({omega * omega, 4e6}, {d, 3.0}, {1, 0.5});
    const auto sound = modal::synthesize(rings, {1e-4}, 44100, 500);
    EXPECT_GT(peak_of(sound), 0);
    return 2 - int(modal::sounding_modes(rings, 44100));
  };
  EXPECT_EQ(with(0.999 * nyquist, 5), 0);
  EXPECT_EQ(with(1.001 * nyquist, 5), 1);
  EXPECT_EQ(with(nyquist, 0), 1);
  // Damping lowers the frequency: it is the damped one that counts.
  EXPECT_EQ(with(1.001 * nyquist, 0.1 * nyquist), 0);
  EXPECT_EQ(with(3 * nyquist, 3 * nyquist), 0);
}

TEST(Synthesize, IsContinuousThroughCriticalDamping) {
  const double omega = 2 * std::numbers::pi * 300;
  for (const double contact_time : {0.0, 1e-3}) {
    const auto sound = [&](double ratio) {
      return modal::synthesize(one_row({omega * omega}, {ratio * omega}, {1}), {contact_time},
                               44100, 600);
    };
    const auto critical = sound(1);
    const double scale = peak_of(critical);
    for (const double step : {1e-3, 1e-6, 1e-9, 1e-12}) {
      for (const double ratio : {1 - step, 1 + step}) {
        const auto near = sound(ratio);
        for (std::size_t n = 0; n < near.size(); ++n) {
          ASSERT_NEAR(near[n], critical[n], (3 * step + 1e-7) * scale) << ratio << " at " << n;
        }
      }
    }
  }
}

TEST(Synthesize, NeverGivesNaNHoweverStrongTheDamping) {
  for (const double frequency : {0.0, 1e-6, 20.0, 440.0, 20000.0}) {
    for (const double ratio : {0.0, 1e-12, 0.5, 0.994, 1.0, 1.006, 1.5, 1e3, 1e9, 1e60}) {
      for (const double contact_time : {0.0, 1e-12, 1e-3, 0.1}) {
        for (const bool pressure : {false, true}) {
          const double omega = 2 * std::numbers::pi * frequency;
          const modal::RingDown rings =
              one_row({omega * omega}, {ratio * std::max(omega, 1.0)}, {1}, pressure);
          for (const float s : modal::synthesize(rings, {contact_time}, 44100, 200)) {
            ASSERT_TRUE(std::isfinite(s) || (pressure && contact_time == 0))
                << frequency << " " << ratio << " " << contact_time;
          }
        }
      }
    }
  }
}

TEST(Synthesize, OverdampedModesAreTwoRealExponentials) {
  const double omega = 1000, d = 1700;
  const double split = std::sqrt(d * d - omega * omega);
  const double s1 = -d + split, s2 = -d - split;
  const auto sound = modal::synthesize(one_row({omega * omega}, {d}, {1}), {0}, 44100, 3000);
  for (std::size_t n = 0; n < sound.size(); ++n) {
    const double t = double(n) / 44100;
    const double expected = (s1 * std::exp(s1 * t) - s2 * std::exp(s2 * t)) / (s1 - s2);
    ASSERT_NEAR(sound[n], expected, 1e-7) << n;
  }
}

// The envelope of one mode falls by 60 dB in T60.
TEST(Synthesize, DecaysBySixtyDecibelsInT60) {
  // T60 of half a second: a whole number of periods, so that both windows begin at a crest.
  const double omega = 2 * std::numbers::pi * 1000, d = std::log(1000.0) / 0.5;
  EXPECT_DOUBLE_EQ(modal::t60(d), 0.5);
  constexpr double audio_rate = 352800;  // fine enough to meet the peaks
  const auto sound = modal::synthesize(one_row({omega * omega}, {d}, {1}), {0}, audio_rate, 220000);
  const auto level = [&](double t) {
    double peak = 0;
    const auto begin = std::size_t(t * audio_rate);
    for (std::size_t n = begin; n < begin + 1764; ++n) {
      peak = std::max(peak, std::abs(double(sound[n])));
    }
    return 20 * std::log10(peak);
  };
  EXPECT_NEAR(level(0) - level(modal::t60(d)), 60, 0.005);
}

TEST(Synthesize, DelaysByFractionsOfASample) {
  modal::RingDown rings = random_rings(10, 9, false);
  constexpr double audio_rate = 8000;
  // 10.25 samples of delay: the same values as at four times the rate, three quarters in between.
  rings.readout.delays = {10.25 / audio_rate};
  const auto delayed = modal::synthesize(rings, {1e-3}, audio_rate, 500);
  rings.readout.delays = {0};
  modal::RingDown fine = rings;
  const auto reference = modal::synthesize(fine, {1e-3}, 4 * audio_rate, 2000);
  const std::size_t sounding = modal::sounding_modes(rings, audio_rate);
  for (std::size_t i = fine.eigenvalues.size(); i-- > 0;) {
    if (std::sqrt(fine.eigenvalues[i]) >= std::numbers::pi * audio_rate)
      fine.readout.velocity(0, Eigen::Index(i)) = 0;
  }
  const auto audible =
      sounding < 10 ? modal::synthesize(fine, {1e-3}, 4 * audio_rate, 2000) : reference;
  for (std::size_t n = 0; n < 11; ++n) EXPECT_EQ(delayed[n], 0) << n;
  for (std::size_t n = 11; n < 500; ++n) {
    ASSERT_NEAR(delayed[n], audible[4 * n - 41], 1e-6 * peak_of(audible)) << n;
  }
}

TEST(Synthesize, GivesTheSameBitsTwice) {
  const modal::RingDown rings = random_rings(64, 11, true);
  EXPECT_EQ(modal::synthesize(rings, {1e-3}, 44100, 20000),
            modal::synthesize(rings, {1e-3}, 44100, 20000));
}

// A longer clip begins with the shorter one, whatever ends early.
TEST(Synthesize, LongerClipsBeginWithShorterOnes) {
  const modal::RingDown rings = random_rings(64, 12, false);
  const auto longer = modal::synthesize(rings, {1e-3}, 44100, 30011);
  const auto shorter = modal::synthesize(rings, {1e-3}, 44100, 7003);
  EXPECT_TRUE(std::equal(shorter.begin(), shorter.end(), longer.begin()));
}

TEST(Synthesize, EmptyAndSilent) {
  EXPECT_EQ(modal::synthesize(one_row({}, {}, {}), {1e-3}, 44100, 3), std::vector<float>(3, 0.0f));
  EXPECT_EQ(modal::synthesize(one_row({1e6}, {1}, {0}), {1e-3}, 44100, 3),
            std::vector<float>(3, 0.0f));
  EXPECT_TRUE(modal::synthesize(one_row({1e6}, {1}, {1}), {1e-3}, 44100, 0).empty());
  // A strike that reaches the listener after the clip's end.
  modal::RingDown late = one_row({1e6}, {1}, {1});
  late.readout.delays = {1.0};
  EXPECT_EQ(modal::synthesize(late, {1e-3}, 44100, 3), std::vector<float>(3, 0.0f));
}

TEST(Synthesize, RefusesWhatCannotBe) {
  const auto good = one_row({1e6}, {1}, {1});
  const auto broken = [&](auto change) {
    modal::RingDown rings = good;
    change(rings);
    return rings;
  };
  const double nan = std::nan("");
  EXPECT_THROW(modal::synthesize(good, {-1e-3}, 44100, 3), core::InputError);
  EXPECT_THROW(modal::synthesize(good, {1e-3}, 0, 3), core::InputError);
  EXPECT_THROW(modal::synthesize(good, {nan}, 44100, 3), core::InputError);
  EXPECT_THROW(modal::synthesize(broken([](auto& r) { r.decay_rates = {-1}; }), {0}, 44100, 3),
               core::InputError);
  EXPECT_THROW(modal::synthesize(broken([&](auto& r) { r.decay_rates = {nan}; }), {0}, 44100, 3),
               core::InputError);
  EXPECT_THROW(
      modal::synthesize(broken([&](auto& r) { r.decay_rates = {INFINITY}; }), {0}, 44100, 3),
      core::InputError);
  EXPECT_THROW(modal::synthesize(broken([](auto& r) { r.eigenvalues = {-1}; }), {0}, 44100, 3),
               core::InputError);
  EXPECT_THROW(
      modal::synthesize(broken([&](auto& r) { r.readout.velocity(0, 0) = nan; }), {0}, 44100, 3),
      core::InputError);
  EXPECT_THROW(modal::synthesize(broken([](auto& r) { r.readout.delays = {-1}; }), {0}, 44100, 3),
               core::InputError);
  EXPECT_THROW(modal::synthesize(broken([](auto& r) { r.readout.delays = {}; }), {0}, 44100, 3),
               core::InputError);
  EXPECT_THROW(modal::synthesize(broken([](auto& r) { r.eigenvalues = {}; }), {0}, 44100, 3),
               core::InputError);
}

}  // namespace
}  // namespace carillon::synth
