#include "eval/material/struck_modes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "core/error.hpp"
#include "eval/material/loudness.hpp"
#include "tests/eval/struck_bodies.hpp"
#include "tests/synth/curved_bodies.hpp"

namespace carillon::eval {
namespace {

constexpr double pi = std::numbers::pi;
const synth::modal::SurfacePoint somewhere{5, {0.2, 0.3, 0.5}};

solvers::modes::Modes modes_of(const std::vector<double>& frequencies,
                               const std::function<Vec3(int, const Vec3&)>& shape) {
  std::vector<double> eigenvalues;
  for (const double f : frequencies) eigenvalues.push_back(std::pow(2 * pi * f, 2));
  return synth::modes_with(synth::curved_sphere(0.1, Vec3::Zero(), 2, 3), eigenvalues, shape);
}

Vec3 wavy(int mode, const Vec3& x) {
  return {std::sin(3 * x.x() + mode), std::cos(2 * x.y() * (mode + 1)),
          std::sin(x.z() + 0.5 * mode * x.x())};
}

material::StruckModes two_modes() {
  material::StruckModes modes;
  modes.specific_modulus = 1e7;
  modes.complete_to_hz = 20000;
  for (const double f : {500.0, 2000.0}) modes.eigenvalues.push_back(std::pow(2 * pi * f, 2));
  modes.gains = {3, -2};
  return modes;
}

material::Candidate candidate(double modulus, double alpha1, double alpha2, double contact = 0) {
  material::Candidate one;
  one.specific_modulus = modulus;
  one.contact_time = contact;
  one.damping = synth::damping::rayleigh_damping(alpha1, alpha2);
  return one;
}

TEST(StruckModes, OfAPairDoNotDependOnItsBasis) {
  const auto shape = [](double turn) {
    return [turn](int mode, const Vec3& x) {
      const Vec3 a = wavy(0, x);
      const Vec3 b = wavy(1, x);
      const double x_fraction = mode == 0 ? std::cos(turn) : -std::sin(turn);
      const double y_fraction = mode == 0 ? std::sin(turn) : std::cos(turn);
      return Vec3(x_fraction * a + y_fraction * b);
    };
  };
  const Vec3 down(0, 0, -1);
  const auto one = material::struck_modes(modes_of({400, 400}, shape(0)), somewhere, down, 1e7);
  const auto other = material::struck_modes(modes_of({400, 400}, shape(0.7)), somewhere, down, 1e7);
  ASSERT_EQ(one.gains.size(), 1U);
  ASSERT_EQ(other.gains.size(), 1U);
  EXPECT_NEAR(one.gains[0], other.gains[0], 1e-6 * std::abs(one.gains[0]));
  EXPECT_EQ(
      material::struck_modes(modes_of({400, 401}, shape(0)), somewhere, down, 1e7).gains.size(),
      2U);
}

/// What is heard of a pair is the sum of both, however the solver turned them; each mode's
/// loudness is pressure per acceleration times the coordinate's impulse.
TEST(RadiatedModes, OfAPairDoNotDependOnItsBasis) {
  const Vec3 down(0, 0, -1);
  const Eigen::RowVector2cd pressure{{{0.3, -0.8}, {-1.1, 0.2}}};
  const auto heard = [&](double turn) {
    const auto shape = [turn](int mode, const Vec3& x) {
      const double quarter = mode == 0 ? 0 : pi / 2;
      return Vec3(std::cos(turn + quarter) * wavy(0, x) + std::sin(turn + quarter) * wavy(1, x));
    };
    Eigen::Matrix2d turned;
    turned << std::cos(turn), std::sin(turn), -std::sin(turn), std::cos(turn);
    const synth::radiation::ModalPressure field{(turned * pressure.transpose()).transpose(), {0}};
    return material::radiated_modes(modes_of({400, 400}, shape), somewhere, down, 1e7, field, 0,
                                    std::vector{3.0, 3.0});
  };
  const material::StruckModes one = heard(0), other = heard(0.7);
  ASSERT_EQ(one.gains.size(), 1U);
  EXPECT_NEAR(one.gains[0], other.gains[0], 1e-6 * one.gains[0]);
  const auto impulse = [&](int mode) {
    const auto shape = [mode](int, const Vec3& x) { return wavy(mode, x); };
    return synth::modal::shapes_at(modes_of({400}, shape), somewhere).row(0).dot(down);
  };
  EXPECT_NEAR(one.gains[0], std::abs(pressure[0] * impulse(0) + pressure[1] * impulse(1)),
              1e-6 * one.gains[0]);
  // What is radiated comes on top of the material's damping, whatever the modulus.
  for (const double modulus : {1e7, 2e7}) {
    const auto tones = material::heard_candidate(one, candidate(modulus, 10, 0),
                                                 material::HeardMotion::acceleration, 20, 20000)
                           .tones;
    ASSERT_EQ(tones.size(), 1U);
    EXPECT_DOUBLE_EQ(tones[0].decay_rate, 5 + 3);
    EXPECT_NEAR(tones[0].amplitude / (one.gains[0] * 2 * pi * 400 * std::sqrt(modulus / 1e7)), 1,
                1e-4);
  }
  const synth::radiation::ModalPressure none{Eigen::MatrixXcd(1, 3), {0}};
  const auto shape = [](int mode, const Vec3& x) { return wavy(mode, x); };
  EXPECT_THROW(
      material::radiated_modes(modes_of({400, 500}, shape), somewhere, down, 1e7, none, 0, {}),
      core::InputError);
}

TEST(HeardCandidate, GoesWithTheRootOfTheModulus) {
  for (const double ratio : {0.25, 1.0, 4.0}) {
    const auto heard = material::heard_candidate(two_modes(), candidate(ratio * 1e7, 2, 0),
                                                 material::HeardMotion::velocity, 20, 20000);
    ASSERT_EQ(heard.tones.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
      const double natural = (i == 0 ? 500 : 2000) * std::sqrt(ratio);
      const double damped = std::sqrt(natural * natural - std::pow(1 / (2 * pi), 2));
      EXPECT_NEAR(heard.tones[i].frequency, damped, 1e-9 * natural);
      EXPECT_DOUBLE_EQ(heard.tones[i].decay_rate, 1);
      // Velocity after a unit impulse, whatever the stiffness.
      EXPECT_NEAR(heard.tones[i].amplitude, (i == 0 ? 3 : 2) * natural / damped, 1e-9);
    }
  }
}

TEST(HeardCandidate, OfAnotherMotionHasOtherAmplitudes) {
  const auto at = [](material::HeardMotion motion) {
    return material::heard_candidate(two_modes(), candidate(1e7, 2, 0), motion, 20, 20000).tones;
  };
  const auto velocity = at(material::HeardMotion::velocity);
  const auto acceleration = at(material::HeardMotion::acceleration);
  const auto displacement = at(material::HeardMotion::displacement);
  for (std::size_t i = 0; i < 2; ++i) {
    const double omega = 2 * pi * (i == 0 ? 500 : 2000);
    EXPECT_NEAR(acceleration[i].amplitude / velocity[i].amplitude, omega, 1e-6 * omega);
    EXPECT_NEAR(velocity[i].amplitude / displacement[i].amplitude, omega, 1e-6 * omega);
  }
  for (const char* name : {"displacement", "velocity", "acceleration"}) {
    EXPECT_EQ(material::name_of(material::parse_heard_motion(name)), name);
  }
  EXPECT_THROW(material::parse_heard_motion("speed"), core::InputError);
}

TEST(HeardCandidate, LosesWhatTheContactHides) {
  // A raised cosine's spectrum is 1 / 2 at 1 / T and zero at 2 / T.
  const auto heard = material::heard_candidate(two_modes(), candidate(1e7, 1e-6, 0, 1.0 / 2000),
                                               material::HeardMotion::velocity, 20, 20000);
  EXPECT_NEAR(heard.tones[1].amplitude, 2 * 0.5, 1e-6);
  const auto longer = material::heard_candidate(two_modes(), candidate(1e7, 1e-6, 0, 1.0 / 1000),
                                                material::HeardMotion::velocity, 20, 20000);
  EXPECT_TRUE(longer.tones.size() == 1 || longer.tones[1].amplitude < 1e-6);
}

TEST(HeardCandidate, IsReferredToTheBeginOfTheContact) {
  // The Laplace transform of (1 - cos(2 pi t / T)) / T, 0 <= t <= T, at the pole s = -d + i omega.
  const double contact = 1.0 / 1500;
  const auto heard = material::heard_candidate(two_modes(), candidate(1e7, 1600, 0, contact),
                                               material::HeardMotion::velocity, 20, 20000);
  ASSERT_EQ(heard.tones.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const std::complex<double> s(-800, 2 * pi * heard.tones[i].frequency);
    const std::complex<double> x = s * contact;
    const std::complex<double> force =
        (1.0 - std::exp(-x)) / (x * (1.0 + std::pow(x / (2 * pi), 2)));
    const double amplitude = (i == 0 ? 3 : 2) * std::abs(s * force) / s.imag();
    EXPECT_NEAR(heard.tones[i].amplitude / amplitude, 1, 1e-9);
  }
}

TEST(HeardCandidate, SoundsLikeTheSynthesisedStrike) {
  // The program's own synthesis of the same modes, after the contact; tones in bands of their own.
  const auto modes = modes_of({310, 1100, 2700, 6100}, wavy);
  synth::modal::Strike strike;
  strike.point = somewhere;
  strike.direction = -synth::modal::frame_at(modes.surface, somewhere).normal;
  strike.impulse = 0.02;
  strike.force.duration = 1.5e-4;
  const std::vector damping = {synth::damping::rayleigh_damping(12, 1.5e-6)};
  const auto rings =
      synth::modal::ring_down(modes, synth::damping::decay_rates(modes, damping), strike,
                              synth::modal::point_velocity(modes, somewhere));
  const std::size_t skipped = 20;  // samples; 0.45 ms
  const auto sound = synth::modal::synthesize(rings, strike.force, 44100, 22050);
  const std::vector<double> samples(sound.begin() + skipped, sound.end());

  material::Candidate known = candidate(1e7, 12, 1.5e-6, 1.5e-4);
  known.scale = 0.02;
  const auto struck = material::struck_modes(modes, somewhere, strike.direction, 1e7);
  const auto heard =
      material::heard_candidate(struck, known, material::HeardMotion::velocity, 20, 20000);
  const auto grid = material::make_grid(samples.size(), 44100, skipped / 44100.0);
  const material::BandPowers truth = material::band_powers(samples, grid);
  const material::BandPowers powers = material::band_powers(heard.tones, grid);
  int compared = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const auto frame = truth.begin() + static_cast<std::ptrdiff_t>(i - i % grid.bands);
    const double loudest =
        *std::max_element(frame, frame + static_cast<std::ptrdiff_t>(grid.bands));
    if (truth[i] < 0.01 * loudest) continue;
    EXPECT_NEAR(powers[i] / truth[i], 1, 0.05) << i / grid.bands << ", band " << i % grid.bands;
    ++compared;
  }
  EXPECT_GT(compared, 20);
}

TEST(HeardCandidate, LeavesOutWhatDoesNotRing) {
  const auto count = [](const material::Candidate& one) {
    return material::heard_candidate(two_modes(), one, material::HeardMotion::velocity, 20, 20000);
  };
  EXPECT_EQ(count(candidate(1e7, 1e6, 0)).tones.size(), 0U);           // far beyond critical
  EXPECT_EQ(count(candidate(1e7, 4 * pi * 500, 0)).tones.size(), 1U);  // critical at 500 Hz
  EXPECT_EQ(count(candidate(4e10, 1, 0)).tones.size(), 0U);            // above the band
  EXPECT_EQ(count(candidate(1e2, 1, 0)).tones.size(), 0U);             // below it
  material::Candidate dips = candidate(1e7, 0, 0);
  dips.damping = {synth::damping::DampingKind::caughey, {10, -1e-6}, ""};
  const auto heard = count(dips);
  ASSERT_EQ(heard.tones.size(), 1U);
  EXPECT_EQ(heard.modes[0], 0U);
  EXPECT_GT(heard.negative, 0);
  EXPECT_LE(heard.negative, 1);
  dips.damping = {
      synth::damping::DampingKind::expression, {1}, "alpha1*ln(-lambda)"};  // not a number
  EXPECT_EQ(count(dips).tones.size(), 0U);
  EXPECT_EQ(count(dips).negative, 1);
}

}  // namespace
}  // namespace carillon::eval
