// Modes that cannot be heard: what is left out and that the error stays below its bound.
#include "synth/modal/thrift.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "core/error.hpp"
#include "random_rings.hpp"
#include "synth/modal/hearing.hpp"
#include "synth/modal/mode_norms.hpp"

namespace carillon::synth {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRate = 44100;

struct Tone {
  double frequency, decay_rate, amplitude;  ///< amplitude of the velocity or pressure
};

/// Modes whose velocity is heard at once after an ideal blow.
modal::RingDown tones(const std::vector<Tone>& list, const std::string& unit) {
  modal::RingDown rings;
  const auto count = static_cast<Eigen::Index>(list.size());
  rings.excitation.resize(count);
  rings.readout.velocity = Eigen::MatrixXd::Ones(1, count);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const double w = 2 * kPi * list[i].frequency;
    rings.eigenvalues.push_back(w * w);
    rings.decay_rates.push_back(list[i].decay_rate);
    rings.excitation[static_cast<Eigen::Index>(i)] = list[i].amplitude;
  }
  rings.readout.delays = {0.0};
  rings.readout.unit = unit;
  return rings;
}

std::vector<double> left(modal::RingDown rings, const modal::ContactForce& force = {}) {
  modal::leave_out_inaudible(rings, force, kRate, 44100, {});
  std::vector<double> frequencies;
  for (const double lambda : rings.eigenvalues) {
    frequencies.push_back(std::round(std::sqrt(lambda) / (2 * kPi)));
  }
  return frequencies;
}

double pascal(double level) {
  return 20e-6 * std::sqrt(2.0) * std::pow(10, level / 20);
}

TEST(Hearing, AgreesWithTheTables) {
  // Zwicker's critical-band rate at 100 Hz, 1 kHz, 10 kHz; Terhardt's threshold at 1 and 4 kHz.
  EXPECT_NEAR(modal::bark(100), 1.0, 0.05);
  EXPECT_NEAR(modal::bark(1000), 8.5, 0.05);
  EXPECT_NEAR(modal::bark(10000), 22.4, 0.1);
  EXPECT_NEAR(modal::hearing_threshold(1000), 3.37, 0.02);
  EXPECT_NEAR(modal::hearing_threshold(4000), -3.39, 0.02);
  EXPECT_TRUE(std::isinf(modal::hearing_threshold(0)));
  // +25 dB and -10 dB per Bark, nothing lost at the tone itself.
  EXPECT_NEAR(modal::spreading(0), 0, 0.02);
  EXPECT_NEAR(modal::spreading(21) - modal::spreading(20), -10, 0.05);
  EXPECT_NEAR(modal::spreading(-20) - modal::spreading(-21), 25, 0.05);
}

TEST(Thrift, LeavesOutWhatIsBelowTheThreshold) {
  // 10 dB of margin: a steady 3 kHz tone is heard from -6 dB on, so -20 dB goes and -12 dB stays.
  EXPECT_EQ(left(tones({{200, 1, pascal(60)}, {3000, 0.1, pascal(-20)}}, "Pa")),
            (std::vector<double>{200}));
  EXPECT_EQ(left(tones({{200, 1, pascal(60)}, {3000, 0.1, pascal(-12)}}, "Pa")),
            (std::vector<double>{200, 3000}));
  // Short tones must be louder: 1 / (2 d 0.2 s) of the energy.
  EXPECT_EQ(left(tones({{200, 1, pascal(60)}, {3000, 1000, pascal(-3)}}, "Pa")),
            (std::vector<double>{200}));
}

TEST(Thrift, TakesDrySignalsRelativeToTheLoudest) {
  for (const double scale : {1e-9, 1.0, 1e9}) {
    EXPECT_EQ(left(tones({{200, 1, scale}, {9000, 0.5, 1e-5 * scale}}, "m/s")),
              (std::vector<double>{200}));
    EXPECT_EQ(left(tones({{200, 1, scale}, {9000, 0.5, 1e-4 * scale}}, "m/s")),
              (std::vector<double>{200, 9000}));
  }
}

TEST(Thrift, LeavesOutWhatIsMaskedWhileItIs) {
  // 35 dB below a neighbour: hidden, if the neighbour lasts as long.
  EXPECT_EQ(left(tones({{1000, 5, 1}, {1040, 5, 0.0178}}, "m/s")), (std::vector<double>{1000}));
  EXPECT_EQ(left(tones({{1000, 5, 1}, {1040, 4, 0.0178}}, "m/s")),
            (std::vector<double>{1000, 1040}));
  // An octave and more away nothing is hidden, below even less than above.
  EXPECT_EQ(left(tones({{1000, 5, 1}, {4000, 5, 0.0178}}, "m/s")),
            (std::vector<double>{1000, 4000}));
  EXPECT_EQ(left(tones({{1000, 5, 1}, {700, 5, 0.0178}}, "m/s")).size(), 2u);
}

TEST(Thrift, LeavesOutWhatDiesAtOnce) {
  // Equal at the start; one is gone within a millisecond, the other rings on.
  EXPECT_EQ(left(tones({{500, 1, 1}, {9000, 8000, 1e-3}}, "m/s")), (std::vector<double>{500}));
  EXPECT_EQ(left(tones({{500, 1, 1}, {9000, 1, 1e-3}}, "m/s")), (std::vector<double>{500, 9000}));
}

TEST(Thrift, CountsWhatIsForcedDuringTheContact) {
  // After half a millisecond of contact nothing of this mode rings, but it gave way meanwhile.
  EXPECT_EQ(left(tones({{500, 1, 1}, {15000, 40000, 1}}, "m/s"), {.duration = 5e-4}),
            (std::vector<double>{500, 15000}));
  EXPECT_EQ(left(tones({{500, 1, 1}, {15000, 40000, 1e-3}}, "m/s"), {.duration = 5e-4}),
            (std::vector<double>{500}));
}

TEST(Thrift, AnyRowThatHearsAModeKeepsIt) {
  modal::RingDown rings = tones({{1000, 5, 1}, {1040, 5, 0.0178}}, "m/s");
  rings.readout.velocity.conservativeResize(2, Eigen::NoChange);
  rings.readout.velocity.row(1) << 0.01, 1;
  rings.readout.delays = {0, 0.001};
  EXPECT_EQ(left(rings).size(), 2u);
}

TEST(Thrift, KeepsWhatDoesNotRing) {
  modal::RingDown rings =
      tones({{1000, 5, 1}, {30, 400, 1e-6}, {50, 2 * kPi * 50, 1e-6}, {30000, 1, 1}}, "m/s");
  modal::leave_out_inaudible(rings, {}, kRate, 44100, {});
  EXPECT_EQ(rings.eigenvalues.size(), 4u);
}

TEST(Thrift, IsTheEffectItSaysInEveryArray) {
  modal::RingDown rings = tones({{9000, 0.5, 1e-6}, {200, 1, 1}, {300, 1, 1}}, "m/s");
  rings.readout.velocity << 1, 2, 3;
  rings.readout.displacement = Eigen::MatrixXd::Zero(1, 3);
  const modal::ThriftReport report = modal::leave_out_inaudible(rings, {}, kRate, 44100, {});
  EXPECT_EQ(report.left_out, 1u);
  EXPECT_EQ(rings.excitation.size(), 2);
  EXPECT_EQ(rings.decay_rates.size(), 2u);
  EXPECT_EQ(rings.readout.displacement.cols(), 2);
  EXPECT_EQ(rings.readout.velocity, (Eigen::MatrixXd(1, 2) << 2, 3).finished());
}

TEST(ModeNorms, AreThoseOfTheSamples) {
  const std::size_t count = 3000;
  const std::vector<modal::SampledPartial> partials = {{{1, 0.5}, {-1e-3, 0.3}},
                                                       {{-0.7, 0.2}, {-2e-3, 0.3000001}},
                                                       {{0.2, 0}, {0, 2.9}},
                                                       {{0.1, 1}, {0, 1e-6}}};
  double square = 0;
  for (std::size_t n = 0; n < count; ++n) {
    double sum = 0;
    for (const auto& p : partials) {
      sum += (p.amplitude * std::exp(static_cast<double>(n) * p.step)).real();
    }
    square += sum * sum;
  }
  const modal::NormBounds norm = modal::norm_of_sum(partials, count);
  EXPECT_NEAR(norm.low / std::sqrt(square), 1, 1e-8);
  EXPECT_LE(norm.low, std::sqrt(square));
  EXPECT_NEAR(norm.high / std::sqrt(square), 1, 1e-8);
  EXPECT_GE(norm.high, std::sqrt(square));
  EXPECT_EQ(modal::norm_of_sum(partials, 0).high, 0);
}

/// Relative L2 difference of two clips' rows, the worst.
double difference(const std::vector<float>& full, const std::vector<float>& kept,
                  std::size_t rows) {
  double worst = 0;
  const std::size_t count = full.size() / rows;
  for (std::size_t r = 0; r < rows; ++r) {
    double missing = 0, whole = 0;
    for (std::size_t n = r * count; n < (r + 1) * count; ++n) {
      const double a = full[n], b = kept[n];
      missing += (a - b) * (a - b);
      whole += a * a;
    }
    if (whole > 0) worst = std::max(worst, std::sqrt(missing / whole));
  }
  return worst;
}

RC_GTEST_PROP(Thrift, ErrorStaysBelowItsBound, ()) {
  const auto range = [](double low, double high) {
    return low + (high - low) * *rc::gen::inRange(0, 1001) / 1000;
  };
  const bool pressure = *rc::gen::arbitrary<bool>();
  modal::RingDown rings =
      random_rings(*rc::gen::inRange(1, 60), *rc::gen::arbitrary<unsigned>(), pressure);
  // Levels over 120 dB, so that something is left out; now and then a mode that does not ring.
  for (Eigen::Index i = 0; i < rings.excitation.size(); ++i) {
    rings.excitation[i] = std::pow(10, range(-6, 0)) * (pressure ? 1e-4 : 1);
  }
  if (*rc::gen::inRange(0, 4) == 0) {
    rings.decay_rates[0] = std::sqrt(rings.eigenvalues[0]) * range(0.99, 2);
  }
  modal::ContactForce force{.duration = *rc::gen::element(0.0, 1e-4, 2e-3)};
  const std::size_t count = static_cast<std::size_t>(*rc::gen::inRange(50, 12000));
  const modal::ThriftOptions options{range(0, 12), range(20, 90)};
  modal::RingDown kept = rings;
  const modal::ThriftReport report = modal::leave_out_inaudible(kept, force, kRate, count, options);
  const std::size_t rows = rings.readout.delays.size();
  const double actual = difference(modal::synthesize(rings, force, kRate, count),
                                   modal::synthesize(kept, force, kRate, count), rows);
  RC_TAG(report.left_out == 0 ? "nothing" : report.masked > 0 ? "masked" : "soft");
  RC_ASSERT(rings.eigenvalues.size() == kept.eigenvalues.size() + report.left_out);
  // Single precision of the samples, and what synthesize() leaves of tails.
  RC_ASSERT(actual <= report.error_bound * (1 + 1e-5) + 2e-7);
  if (report.left_out == 0) RC_ASSERT(report.error_bound == 0);
}

TEST(Thrift, BoundIsNotFarOff) {
  // Sixty modes over 120 dB: how much the bound exceeds the error, typically.
  double worst = 0;
  int used = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    modal::RingDown rings = random_rings(60, seed, false);
    for (Eigen::Index i = 0; i < 60; ++i) {
      rings.excitation[i] = std::pow(10, -6.0 * static_cast<double>((i * 7) % 60) / 60);
    }
    modal::RingDown kept = rings;
    const modal::ThriftReport report =
        modal::leave_out_inaudible(kept, {.duration = 2e-4}, kRate, 44100, {});
    if (report.left_out == 0) continue;
    const double actual = difference(modal::synthesize(rings, {.duration = 2e-4}, kRate, 44100),
                                     modal::synthesize(kept, {.duration = 2e-4}, kRate, 44100), 1);
    worst = std::max(worst, modal::decibels(report.error_bound) - 20 * std::log10(actual));
    ++used;
  }
  EXPECT_GE(used, 10);
  EXPECT_LT(worst, 15);
}

TEST(Thrift, ABurstOfNoiseIsBoundedToo) {
  modal::RingDown rings =
      tones({{500, 3, 1}, {520, 4, 0.01}, {9000, 50, 1e-4}, {14000, 900, 1e-5}}, "m/s");
  modal::ContactForce force{.duration = 2e-3};
  for (int k = 0; k <= 88; ++k) {
    force.samples.push_back(1000 * std::sin(0.7 * k * k) * std::sin(kPi * k / 88));
  }
  const modal::ThriftReport report = modal::leave_out_inaudible(rings, force, kRate, 44100, {});
  EXPECT_GE(report.left_out, 1u);
  EXPECT_GT(report.error_bound, 0);
  EXPECT_LT(report.error_bound, 0.05);
}

TEST(Thrift, RefusesMarginsThatAreNone) {
  modal::RingDown rings = tones({{500, 3, 1}}, "m/s");
  EXPECT_THROW(modal::leave_out_inaudible(rings, {}, kRate, 10, {-1, 90}), core::InputError);
  EXPECT_THROW(modal::leave_out_inaudible(rings, {}, kRate, 10, {1, std::nan("")}),
               core::InputError);
}

}  // namespace
}  // namespace carillon::synth
