// Cases that break resonator banks: no damping, too much of it, modes on top of each other, limits
// of the band, long clips, extreme forces. docs/hard-cases.md says what each must come to.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <ctime>
#include <numbers>

#include "core/error.hpp"
#include "synth/modal/ring_down.hpp"
#include "synth/modal/streaming_renderer.hpp"
#include "tests/synth/random_rings.hpp"

namespace carillon::synth {
namespace {

using Real = long double;
constexpr Real pi = std::numbers::pi_v<long double>;
constexpr double audio_rate = 44100;

modal::RingDown velocity_of(std::vector<double> lambda, std::vector<double> d) {
  modal::RingDown rings;
  const auto modes = Eigen::Index(lambda.size());
  rings.excitation = Eigen::VectorXd::Ones(modes);
  rings.readout.velocity = Eigen::RowVectorXd::Ones(modes);
  rings.readout.delays = {0};
  rings.eigenvalues = std::move(lambda);
  rings.decay_rates = std::move(d);
  return rings;
}

/// Velocity after an ideal impulse, summed in extended precision from the solution's own formula
/// with square roots of lambda - d^2 or d^2 - lambda.
Real impulse_velocity(const modal::RingDown& rings, Real t) {
  Real sum = 0;
  for (std::size_t i = 0; i < rings.eigenvalues.size(); ++i) {
    const Real d = rings.decay_rates[i];
    const Real square = Real(rings.eigenvalues[i]) - d * d;
    const Real root = std::sqrt(std::abs(square));
    const Real decay = std::exp(-d * t);
    if (square > 0) {
      sum += decay * (std::cos(root * t) - d * std::sin(root * t) / root);
    } else if (square < 0) {
      // e^{-dt} (cosh - d sinh / root) by its two exponentials.
      sum += 0.5L * (std::exp((root - d) * t) * (1 - d / root) +
                     std::exp(-(root + d) * t) * (1 + d / root));
    } else {
      sum += decay * (1 - d * t);
    }
  }
  return sum;
}

/// Velocity of a mode under the raised cosine of unit impulse: (s1 I(s1) - s2 I(s2)) / (s1 - s2)
/// with I(s, t) the convolution of the force with exp(s t), whose three parts are taken one by one.
Real pulse_velocity(Real lambda, Real d, Real duration, Real t) {
  using Number = std::complex<Real>;
  const Number root = std::sqrt(Number(d * d - lambda));
  const Number s2 = -d - root, s1 = lambda / s2;
  const Real turn = 2 * pi / duration;
  const Real until = std::min(t, duration);
  const auto convolution = [&](Number s) {
    const auto part = [&](Number frequency) {
      return (std::exp(frequency * until) - std::exp(s * until)) / (frequency - s);
    };
    const Number sum = part(0) - 0.5L * (part({0, turn}) + part({0, -turn}));
    return sum / duration * std::exp(s * (t - until));
  };
  return ((s1 * convolution(s1) - s2 * convolution(s2)) / (s1 - s2)).real();
}

/// Largest deviation relative to the peak.
double deviation(const modal::RingDown& rings, const std::vector<float>& sound,
                 std::size_t begin = 0) {
  double peak = 0, worst = 0;
  for (std::size_t n = begin; n < sound.size(); ++n) {
    const Real expected = impulse_velocity(rings, Real(n) / Real(audio_rate));
    peak = std::max(peak, double(std::abs(expected)));
    worst = std::max(worst, double(std::abs(expected - Real(sound[n]))));
  }
  return worst / peak;
}

TEST(KernelHard, NoDampingRingsOnForTheWholeClip) {
  std::vector<double> lambda;
  for (const double f : {31.0, 440.0, 3000.1, 21999.0}) {
    lambda.push_back(std::pow(2 * std::numbers::pi * f, 2));
  }
  const modal::RingDown rings = velocity_of(lambda, std::vector<double>(lambda.size(), 0));
  EXPECT_LT(deviation(rings, modal::synthesize(rings, {0}, audio_rate, 200000)), 1e-6);
}

TEST(KernelHard, DampingAtAndBeyondCritical) {
  const double omega = 2 * std::numbers::pi * 200;
  for (const double ratio : {0.999999999, 1.0, 1.000000001, 1.0049, 1.0051, 3.0, 1e3, 1e9}) {
    const modal::RingDown rings = velocity_of({omega * omega}, {ratio * omega});
    const auto sound = modal::synthesize(rings, {0}, audio_rate, 4000);
    // Beyond 1e9 times critical the closed form above loses its digits, not the kernel.
    EXPECT_LT(deviation(rings, sound), ratio < 1e6 ? 1e-6 : 1e-3) << ratio;
    // At the critical damping itself the poles are one: 1e-9 beside it they can be told apart.
    const Real lambda = Real(rings.eigenvalues[0]) * (ratio == 1 ? 1 - 1e-9L : 1);
    const auto struck = modal::synthesize(rings, {1e-3}, audio_rate, 4000);
    double peak = 0, worst = 0;
    for (std::size_t n = 0; n < struck.size(); ++n) {
      const Real expected =
          pulse_velocity(lambda, rings.decay_rates[0], 1e-3, Real(n) / Real(audio_rate));
      peak = std::max(peak, double(std::abs(expected)));
      worst = std::max(worst, double(std::abs(expected - Real(struck[n]))));
    }
    EXPECT_LT(worst, 1e-6 * peak) << ratio;
  }
}

// Two modes 1e-9 apart beat once in years: their sum is twice one of them, and equal and opposite
// ones leave the slope of the beat.
TEST(KernelHard, TwoModesOneBillionthApart) {
  const double omega = 2 * std::numbers::pi * 1000;
  const double other = omega * (1 + 1e-9);
  modal::RingDown rings = velocity_of({omega * omega, other * other}, {1, 1});
  EXPECT_LT(deviation(rings, modal::synthesize(rings, {0}, audio_rate, 40000)), 1e-6);
  rings.readout.velocity(0, 1) = -1;
  const auto beat = modal::synthesize(rings, {0}, audio_rate, 441000);
  const Real first = std::sqrt(Real(rings.eigenvalues[0]) - 1);
  const Real second = std::sqrt(Real(rings.eigenvalues[1]) - 1);
  double peak = 0, worst = 0;
  for (std::size_t n = 0; n < beat.size(); ++n) {
    const Real t = Real(n) / Real(audio_rate);
    // cos a - cos b, and the same of the small sine part.
    const Real expected =
        std::exp(-t) *
        (2 * std::sin((first + second) / 2 * t) * std::sin((second - first) / 2 * t) -
         std::sin(first * t) / first + std::sin(second * t) / second);
    peak = std::max(peak, double(std::abs(expected)));
    worst = std::max(worst, double(std::abs(expected - Real(beat[n]))));
  }
  EXPECT_NEAR(peak, 2.3e-6, 0.3e-6);  // 2 pi 1e-6 t exp(-t) at t = 1 s
  // A beat of 2e-6 of two unit modes, each right to 1e-12.
  EXPECT_LT(worst, 1e-5 * peak);
}

TEST(KernelHard, FrequenciesAtNyquistAreDroppedAndSaid) {
  const double nyquist = std::numbers::pi * audio_rate;
  const double above = std::nextafter(nyquist, 1e9) * (1 + 1e-15);
  const double below = nyquist * (1 - 1e-12);
  const modal::RingDown rings =
      velocity_of({nyquist * nyquist, above * above, below * below, 1e6}, {0, 0, 0, 0});
  const auto sound = modal::synthesize(rings, {0}, audio_rate, 3000);
  EXPECT_EQ(modal::sounding_modes(rings, audio_rate), rings.eigenvalues.size() - 2);
  EXPECT_LT(deviation(velocity_of({below * below, 1e6}, {0, 0}), sound), 1e-6);
  modal::StreamingRenderer renderer(1, audio_rate);
  renderer.add_body(rings.eigenvalues, rings.decay_rates, rings.readout);
  EXPECT_EQ(modal::modes_above_nyquist(rings, audio_rate), 2U);
  renderer.strike(0, rings.excitation, {0});
  std::vector<float> streamed(100);
  renderer.render(streamed);
  EXPECT_EQ(renderer.voices(), rings.eigenvalues.size() - 2);
}

TEST(KernelHard, TwoThousandModes) {
  const modal::RingDown rings = random_rings(2000, 9, false);
  const auto sound = modal::synthesize(rings, {0}, audio_rate, 5000);
  double peak = 0, worst = 0;
  for (std::size_t n = 0; n < sound.size(); n += 13) {
    Real sum = 0;
    for (std::size_t i = 0; i < 2000; ++i) {
      const Real d = rings.decay_rates[i];
      const Real root = std::sqrt(Real(rings.eigenvalues[i]) - d * d);
      const Real t = Real(n) / Real(audio_rate);
      sum += Real(rings.readout.velocity(0, Eigen::Index(i))) * std::exp(-d * t) *
             (std::cos(root * t) - d * std::sin(root * t) / root);
    }
    peak = std::max(peak, double(std::abs(sum)));
    worst = std::max(worst, double(std::abs(sum - Real(sound[n]))));
  }
  EXPECT_LT(worst, 1e-6 * peak);
}

/// Frequency over the whole clip from the phase in its last second: projection on the exact
/// oscillation and its quadrature.
double cents_off(const std::vector<float>& sound, Real omega) {
  Real in_phase = 0, quadrature = 0;
  const std::size_t begin = sound.size() - std::size_t(audio_rate);
  for (std::size_t n = begin; n < sound.size(); ++n) {
    const Real t = Real(n) / Real(audio_rate);
    in_phase += Real(sound[n]) * std::cos(omega * t);
    quadrature -= Real(sound[n]) * std::sin(omega * t);
  }
  EXPECT_NEAR(double(in_phase / (audio_rate / 2)), 1,
              1e-6);  // nothing lost of the amplitude either
  const Real phase = std::atan2(quadrature, in_phase);
  const Real fraction = phase / (omega * (Real(sound.size()) / Real(audio_rate)));
  return double(1200 * std::log2(1 + std::abs(fraction)));
}

TEST(KernelHard, AMinuteWithoutDrift) {
  // Whole periods in the last second.
  for (const double frequency : {50.0, 19876.0}) {
    const double omega = 2 * std::numbers::pi * frequency;
    const modal::RingDown rings = velocity_of({omega * omega}, {0});
    constexpr std::size_t minute = 60 * 44100;
    const auto offline = modal::synthesize(rings, {0}, audio_rate, minute);
    const double off = cents_off(offline, std::sqrt(Real(rings.eigenvalues[0])));
    modal::StreamingRenderer renderer(1, audio_rate);
    renderer.add_body(rings.eigenvalues, rings.decay_rates, rings.readout);
    renderer.strike(0, rings.excitation, {0});
    std::vector<float> streamed(minute);
    for (std::size_t n = 0; n < minute; n += 441) {
      renderer.render(std::span(streamed).subspan(n, 441));
    }
    const double stream_off = cents_off(streamed, std::sqrt(Real(rings.eigenvalues[0])));
    fmt::print("{} Hz: {:.1e} cents, streamed {:.1e}\n", frequency, off, stream_off);
    EXPECT_LT(off, 0.01);
    EXPECT_LT(stream_off, 0.01);
    // The phase itself: a drift of 0.01 cents would be 1e3 rad by now.
    EXPECT_LT(off, 1e-9);
    EXPECT_LT(stream_off, 1e-9);
  }
}

double seconds_of(const modal::RingDown& rings) {
  double best = 1;
  for (int i = 0; i < 5; ++i) {
    const std::clock_t begin = std::clock();
    const auto sound = modal::synthesize(rings, {1e-3}, audio_rate, 44100);
    const double seconds = double(std::clock() - begin) / CLOCKS_PER_SEC;
    if (!sound.empty()) best = std::min(best, seconds);
  }
  return best;
}

TEST(KernelHard, ForcesFromPiconewtonsToTeranewtons) {
  modal::RingDown rings = random_rings(60, 31, true);
  // Modes that die within a block go through all small numbers there are.
  for (std::size_t i = 0; i < 20; ++i) rings.decay_rates[i] = 1e5;
  const modal::RingDown unit = rings;
  const auto reference = modal::synthesize(unit, {1e-3}, audio_rate, 44100);
  double peak = 0;
  for (const float s : reference) peak = std::max(peak, std::abs(double(s)));
  for (const double force : {1e-12, 1e12}) {
    rings.excitation = unit.excitation * force;
    const auto sound = modal::synthesize(rings, {1e-3}, audio_rate, 44100);
    double worst = 0;
    for (std::size_t n = 0; n < sound.size(); ++n) {
      ASSERT_TRUE(std::isfinite(sound[n]));
      worst = std::max(worst, std::abs(double(sound[n]) / force - double(reference[n])));
    }
    EXPECT_LT(worst, 1e-6 * peak) << force;
  }
  // Powers of two change no digit: neither of the samples nor of what ends early.
  for (const int power : {-40, 40}) {
    rings.excitation = unit.excitation * std::ldexp(1.0, power);
    const auto sound = modal::synthesize(rings, {1e-3}, audio_rate, 44100);
    for (std::size_t n = 0; n < sound.size(); ++n) {
      ASSERT_EQ(sound[n], std::ldexp(reference[n], power)) << power << " " << n;
    }
  }
  rings.excitation = unit.excitation * 1e-12;
  const double soft = seconds_of(rings);
  const double hard = seconds_of(unit);
  fmt::print("time of 1e-12 N against 1 N: {:.2f}\n", soft / hard);
}

// A soft striker's contact can last for ever: memory for its samples cannot be had.
TEST(KernelHard, StrikesWithoutEndAreRefused) {
  const auto message = [](const auto& run) -> std::string {
    try {
      run();
    } catch (const core::InputError& error) {
      return error.what();
    }
    return "no error";
  };
  modal::RingDown rings = random_rings(3, 3, false);
  modal::StreamingRenderer renderer(1, audio_rate);
  renderer.add_body(rings.eigenvalues, rings.decay_rates, rings.readout);
  const auto strike = [&](const modal::ContactForce& force, double delay) {
    return message([&] { renderer.strike(0, rings.excitation, force, delay); });
  };
  EXPECT_NE(strike({1e9}, 0).find("1e+09 s is longer than 226.8 s"), std::string::npos);
  EXPECT_NE(strike({1e300}, 0).find("longer than"), std::string::npos);
  EXPECT_NE(strike({1e9, {1, 1}}, 0).find("longer than"), std::string::npos);
  EXPECT_NE(strike({1e-3}, 1e9).find("below a year"), std::string::npos);
  EXPECT_EQ(strike({1}, 2.9e7), "no error");
  rings.readout.delays = {1e12};
  EXPECT_NE(message([&] {
              renderer.add_body(rings.eigenvalues, rings.decay_rates, rings.readout);
            }).find("below a year"),
            std::string::npos);
  // A single strike needs no more than the clip's samples.
  rings.readout.delays = {0};
  for (const float s : modal::synthesize(rings, {1e9}, audio_rate, 100))
    ASSERT_LT(std::abs(s), 1e-6F);
  EXPECT_NE(message([&] {
              modal::synthesize_strikes(rings, {1e9}, std::vector<double>{0, 1}, audio_rate, 100);
            }).find("longer than"),
            std::string::npos);
}

// After three hours a strike sounds to the bit as the first did, and nothing has piled up.
TEST(KernelHard, StreamingStateIsBoundedOverHours) {
  const modal::RingDown rings = random_rings(12, 3, false);
  modal::StreamingRenderer renderer(1, audio_rate);
  renderer.add_body(rings.eigenvalues, rings.decay_rates, rings.readout);
  renderer.strike(0, rings.excitation, {1e-3});
  std::vector<float> first(4096);
  renderer.render(first);
  std::vector<float> silence(44100);
  // Three hours; all but the first seconds are silent.
  for (int second = 0; second < 3 * 3600; ++second) renderer.render(silence);
  EXPECT_EQ(renderer.voices(), 0U);
  renderer.strike(0, rings.excitation, {1e-3});
  std::vector<float> last(4096);
  renderer.render(last);
  EXPECT_EQ(first, last);
}

}  // namespace
}  // namespace carillon::synth
