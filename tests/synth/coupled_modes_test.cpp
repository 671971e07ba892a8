#include "synth/support/coupled_modes.hpp"
#include "synth/support/diagonal_error.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "synth/support/supports.hpp"
#include "tests/synth/support_cases.hpp"

namespace carillon::synth {
namespace {

constexpr double pi = std::numbers::pi;

support::CoupledModes coupled(const HeldModes& held) {
  auto modes = support::couple(held.eigenvalues, held.decay_rates, held.dashpots);
  if (!modes) throw std::runtime_error("not coupled");
  return *modes;
}

/// Struck with random gains and heard through all three parts of a readout, two rows.
modal::RingDown random_ring_down(const HeldModes& held, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto n = static_cast<Eigen::Index>(held.eigenvalues.size());
  modal::RingDown rings;
  rings.eigenvalues = held.eigenvalues;
  rings.decay_rates = held.decay_rates;
  rings.excitation.resize(n);
  for (double& e : rings.excitation) e = normal(random);
  modal::Readout& readout = rings.readout;
  for (auto* gains : {&readout.displacement, &readout.velocity, &readout.acceleration}) {
    gains->resize(2, n);
    for (double& gain : gains->reshaped()) gain = normal(random);
  }
  // Of comparable loudness: each in its own unit.
  readout.displacement *= 3000;
  readout.acceleration /= 3000;
  readout.delays = {0.0, 0.0};
  return rings;
}

/// What rows of a readout are in a state (q, q'), q'' from the equation of motion.
Eigen::VectorXd read_out(const HeldModes& held, const modal::RingDown& rings, double contact_time,
                         double t, const Eigen::VectorXd& state) {
  const Eigen::Index n = state.size() / 2;
  const Eigen::VectorXd q = state.head(n), v = state.tail(n);
  const Eigen::VectorXd a =
      rings.excitation * modal::contact_force(contact_time, t) - held.damping() * v -
      Eigen::Map<const Eigen::VectorXd>(held.eigenvalues.data(), n).cwiseProduct(q);
  const modal::Readout& r = rings.readout;
  return r.displacement * q + r.velocity * v + r.acceleration * a;
}

TEST(CoupledModes, HaveThePolesOfTheStateMatrix) {
  for (const double strength : {1e-3, 1.0, 1e3, 1e5}) {
    const HeldModes held = random_held(12, 3, strength, 5);
    const support::CoupledModes modes = coupled(held);
    EXPECT_LT(worst_pole(poles_of(modes.eigenvalues, modes.decay_rates),
                         eigenvalues_of(held.state_matrix())),
              1e-9)
        << strength;
    EXPECT_EQ(modes.perturbation, 0);
  }
}

TEST(CoupledModes, SoundLikeTheEquationOfMotionByMatrixExponentials) {
  const std::vector<double> times = {0.0, 1e-4, 2.5e-4, 5e-4, 6e-4, 1e-3, 5e-3, 0.03, 0.2};
  for (const double contact_time : {5e-4, 1e-5}) {
    for (const double strength : {1.0, 1e3, 1e5}) {
      const HeldModes held = random_held(8, 3, strength, 11);
      const modal::RingDown rings = random_ring_down(held, 3);
      const modal::RingDown answer = support::coupled_ring_down(coupled(held), rings);
      const auto states = exact_states(held, rings.excitation, contact_time, times);
      double loudest = 0, worst = 0;
      for (std::size_t k = 0; k < times.size(); ++k) {
        const Eigen::VectorXd exact = read_out(held, rings, contact_time, times[k], states[k]);
        loudest = std::max(loudest, exact.lpNorm<Eigen::Infinity>());
        worst = std::max(
            worst, (value_at(answer, contact_time, times[k]) - exact).lpNorm<Eigen::Infinity>());
      }
      EXPECT_LT(worst, 1e-9 * loudest) << strength << " " << contact_time;
    }
  }
}

TEST(CoupledModes, GiveTheSamplesOfTheEquationOfMotion) {
  const HeldModes held = random_held(6, 2, 300, 2);
  const modal::RingDown rings = random_ring_down(held, 8);
  const double rate = 44100;
  const auto samples =
      modal::synthesize(support::coupled_ring_down(coupled(held), rings), {3e-4}, rate, 2000);
  std::vector<double> times;
  for (int n = 0; n < 2000; n += 97) times.push_back(n / rate);
  const auto states = exact_states(held, rings.excitation, 3e-4, times);
  double peak = 0;
  for (const float sample : samples) peak = std::max(peak, std::abs(static_cast<double>(sample)));
  for (std::size_t k = 0; k < times.size(); ++k) {
    const Eigen::VectorXd exact = read_out(held, rings, 3e-4, times[k], states[k]);
    EXPECT_NEAR(samples[97 * k], exact[0], 2e-7 * peak);
    EXPECT_NEAR(samples[2000 + 97 * k], exact[1], 2e-7 * peak);
  }
}

TEST(CoupledModes, OfDashpotsOnOneModeEachAreTheDiagonalAnswer) {
  HeldModes held = random_held(5, 5, 1, 4);
  held.dashpots = Eigen::VectorXd::LinSpaced(5, 1, 9).asDiagonal();
  const support::CoupledModes modes = coupled(held);
  const auto diagonal = diagonal_rates(held.decay_rates, held.dashpots);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(modes.decay_rates[i], diagonal[i], 1e-10 * std::sqrt(held.eigenvalues[i]));
    EXPECT_NEAR(modes.eigenvalues[i], held.eigenvalues[i], 1e-12 * held.eigenvalues[i]);
    EXPECT_NEAR(modes.overlaps[i], 1, 1e-6);
  }
  const support::DiagonalError error = support::diagonal_error(modes, held.eigenvalues, diagonal);
  EXPECT_EQ(error.matched, 5);
  EXPECT_LT(error.decay_rate, 1e-9);
  EXPECT_LT(error.cents, 1e-9);
}

TEST(CoupledModes, WithoutContactsAreTheModes) {
  const HeldModes held = random_held(7, 1, 1, 4);
  const modal::RingDown rings = random_ring_down(held, 1);
  for (const Eigen::MatrixXd& nothing :
       {Eigen::MatrixXd(7, 0), Eigen::MatrixXd(Eigen::MatrixXd::Zero(7, 3))}) {
    const auto modes = support::couple(held.eigenvalues, held.decay_rates, nothing);
    ASSERT_TRUE(modes);
    EXPECT_TRUE(modes->coupled.empty());
    const modal::RingDown answer = support::coupled_ring_down(*modes, rings);
    EXPECT_EQ(answer.eigenvalues, rings.eigenvalues);
    EXPECT_EQ(answer.decay_rates, rings.decay_rates);
    EXPECT_EQ(modal::synthesize(answer, {1e-4}, 44100, 500),
              modal::synthesize(rings, {1e-4}, 44100, 500));
  }
}

TEST(CoupledModes, LeaveAModeThatIsNotTouchedAsItIs) {
  HeldModes held = random_held(9, 2, 500, 6);
  held.dashpots.row(4).setZero();
  const support::CoupledModes modes = coupled(held);
  EXPECT_EQ(modes.eigenvalues[4], held.eigenvalues[4]);
  EXPECT_EQ(modes.decay_rates[4], held.decay_rates[4]);
  EXPECT_EQ(modes.coupled.size(), 8u);
}

// A rod, fixed at one end, with a dashpot c at the other: waves come back with (Z - c) / (Z + c),
// Z = rho A c_L its impedance. Every pole has d = c_L / L atanh(c / Z) and the frequency of the
// free rod; the diagonal answer is c_L / L (c / Z).
TEST(CoupledModes, OfARodOnADashpotDecayAsItsWavesDo) {
  const double length = 0.5, speed = 5000, mass = 0.2, impedance = mass / length * speed;
  const int n = 250;
  HeldModes rod;
  rod.dashpots.resize(n, 1);
  const double c = 0.6 * impedance;
  for (int k = 0; k < n; ++k) {
    rod.eigenvalues.push_back(std::pow((k + 0.5) * pi * speed / length, 2));
    rod.decay_rates.push_back(0);
    rod.dashpots(k, 0) = std::sqrt(c) * std::sqrt(2 / mass) * (k % 2 == 0 ? 1 : -1);
  }
  const support::CoupledModes modes = coupled(rod);
  const double exact = speed / length * std::atanh(0.6);
  const auto diagonal = diagonal_rates(rod.decay_rates, rod.dashpots);
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_NEAR(modes.decay_rates[k], exact, 5e-3 * exact) << k;
    const double damped = std::sqrt(modes.eigenvalues[k] - std::pow(modes.decay_rates[k], 2));
    EXPECT_NEAR(damped, std::sqrt(rod.eigenvalues[k]), 5e-3 * damped) << k;
    EXPECT_NEAR(diagonal[k], speed / length * 0.6, 1e-9 * exact);
  }
}

/// Modes of a free body: `rigid` coordinates without stiffness below the dashpots' other rows.
HeldModes with_rigid(const HeldModes& held, int rigid) {
  HeldModes all = held;
  all.eigenvalues.insert(all.eigenvalues.end(), static_cast<std::size_t>(rigid), 0.0);
  all.decay_rates.insert(all.decay_rates.end(), static_cast<std::size_t>(rigid), 0.0);
  return all;
}

// As above for a rod that is free at its other end: it also moves as a whole, and that motion dies
// away at the same rate.
TEST(CoupledModes, OfAFreeRodOnADashpotCoupleWithItsMotionAsAWhole) {
  const double length = 0.5, speed = 5000, mass = 0.2, impedance = mass / length * speed;
  const int n = 250;
  HeldModes rod;
  rod.dashpots.resize(n + 1, 1);
  const double c = 0.6 * impedance;
  for (int k = 0; k < n; ++k) {
    rod.eigenvalues.push_back(std::pow((k + 1) * pi * speed / length, 2));
    rod.decay_rates.push_back(0);
    rod.dashpots(k, 0) = std::sqrt(c) * std::sqrt(2 / mass);
  }
  rod.dashpots(n, 0) = std::sqrt(c / mass);
  const support::CoupledModes modes = coupled(rod);
  const double exact = speed / length * std::atanh(0.6);
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_NEAR(modes.decay_rates[k], exact, 5e-3 * exact) << k;
    const double damped = std::sqrt(modes.eigenvalues[k] - std::pow(modes.decay_rates[k], 2));
    EXPECT_NEAR(damped, std::sqrt(rod.eigenvalues[k]), 5e-3 * damped) << k;
  }
  ASSERT_EQ(modes.eigenvalues.size(), static_cast<std::size_t>(n + 1));
  EXPECT_NEAR(2 * modes.decay_rates.back(), exact, 5e-3 * exact);  // real poles 0 and -d
  EXPECT_LT(modes.eigenvalues.back(), 1e-6 * exact * exact);
}

TEST(CoupledModes, OfAFreeBodySoundLikeMatrixExponentialsWithItsRigidCoordinates) {
  const std::vector<double> times = {0.0, 1e-4, 5e-4, 6e-4, 1e-3, 5e-3, 0.03};
  for (const int rigid : {1, 2, 5, 6}) {
    for (const double strength : {1.0, 1e3, 1e5}) {
      HeldModes held = random_held(8, 4, strength, 11);
      held.dashpots.conservativeResize(8 + rigid, 4);
      held.dashpots.bottomRows(rigid) = random_held(rigid, 4, strength, 12).dashpots;
      const HeldModes all = with_rigid(held, rigid);
      const modal::RingDown rings = random_ring_down(random_held(8, 4, strength, 11), 3);
      const modal::RingDown answer = support::coupled_ring_down(coupled(held), rings);
      modal::RingDown heard = rings;
      heard.excitation.conservativeResize(8 + rigid);
      heard.excitation.tail(rigid).setZero();
      for (auto* gains :
           {&heard.readout.displacement, &heard.readout.velocity, &heard.readout.acceleration}) {
        gains->conservativeResize(2, 8 + rigid);
        gains->rightCols(rigid).setZero();
      }
      const auto states = exact_states(all, heard.excitation, 5e-4, times);
      double loudest = 0, worst = 0;
      for (std::size_t k = 0; k < times.size(); ++k) {
        const Eigen::VectorXd exact = read_out(all, heard, 5e-4, times[k], states[k]);
        loudest = std::max(loudest, exact.lpNorm<Eigen::Infinity>());
        worst =
            std::max(worst, (value_at(answer, 5e-4, times[k]) - exact).lpNorm<Eigen::Infinity>());
      }
      EXPECT_LT(worst, 1e-8 * loudest) << strength << " " << rigid;
    }
  }
}

TEST(CoupledModes, DiagonalErrorIsEstimatedWithoutSolving) {
  HeldModes held;
  for (const double hertz : {200.0, 550.0, 1080.0, 1790.0}) {
    held.eigenvalues.push_back(std::pow(2 * pi * hertz, 2));
    held.decay_rates.push_back(0);
  }
  held.dashpots.resize(6, 1);
  held.dashpots << 3, -4, 5, 4, 3, 2;
  const auto diagonal = diagonal_rates(held.decay_rates, held.dashpots.topRows(4));
  const support::DiagonalError found =
      support::diagonal_error(coupled(held), held.eigenvalues, diagonal);
  const support::DiagonalError guess =
      support::estimate_diagonal_error(held.eigenvalues, diagonal, held.dashpots);
  EXPECT_NEAR(guess.decay_rate / found.decay_rate, 1, 0.1);
  EXPECT_NEAR(guess.cents / found.cents, 1, 0.1);
  // Equal modes under one dashpot: no order of the force makes the diagonal answer right.
  const std::vector<double> same = {1e6, 1e6}, rates = {1, 1};
  EXPECT_NEAR(support::estimate_diagonal_error(same, rates, Eigen::Vector2d(1, 1)).decay_rate, 0.5,
              0.01);
}

TEST(CoupledModes, NothingComparedIsNotANumber) {
  HeldModes held = random_held(2, 1, 1, 1);
  held.decay_rates = {1e6, 1e6};
  const auto diagonal = diagonal_rates(held.decay_rates, held.dashpots);
  const support::DiagonalError error =
      support::diagonal_error(coupled(held), held.eigenvalues, diagonal);
  EXPECT_EQ(error.matched, 0);
  EXPECT_EQ(error.modes, 2);
  EXPECT_TRUE(std::isnan(error.decay_rate) && std::isnan(error.cents));
}

TEST(CoupledModes, DiagonalErrorFallsWithTheForce) {
  // Between modes far apart, coupling moves a pole by the square of the dashpot.
  HeldModes held;
  for (const double hertz : {200.0, 550.0, 1080.0, 1790.0}) {
    held.eigenvalues.push_back(std::pow(2 * pi * hertz, 2));
    held.decay_rates.push_back(0);
  }
  held.dashpots = Eigen::Vector4d(3, -4, 5, 4);
  const auto off = [&](double factor) {
    HeldModes pressed = held;
    pressed.dashpots *= std::sqrt(factor);
    const auto diagonal = diagonal_rates(pressed.decay_rates, pressed.dashpots);
    return support::diagonal_error(coupled(pressed), pressed.eigenvalues, diagonal);
  };
  const support::DiagonalError once = off(1), twice = off(2);
  EXPECT_EQ(once.matched, 4);
  EXPECT_NEAR(twice.decay_rate / once.decay_rate, 4, 0.05);
  EXPECT_NEAR(twice.cents / once.cents, 4, 0.05);
  EXPECT_NE(describe(once).find("4 of 4 modes"), std::string::npos);
}

TEST(CoupledModes, NeverGainEnergy) {
  rc::check("modal energy never grows, poles are on the left", [] {
    const int n = *rc::gen::inRange(1, 9);
    const int contacts = *rc::gen::inRange(1, 12);
    const double strength = std::pow(10.0, *rc::gen::inRange(-6, 10));
    HeldModes held = random_held(n, contacts, strength, *rc::gen::inRange(0u, 1000u));
    if (*rc::gen::inRange(0, 2) == 1) {
      for (double& d : held.decay_rates) d = 0;
    }
    const auto modes = support::couple(held.eigenvalues, held.decay_rates, held.dashpots);
    RC_ASSERT(modes.has_value());
    for (const auto& pole : poles_of(modes->eigenvalues, modes->decay_rates)) {
      RC_ASSERT(pole.real() <= 0);
    }
    // Rows: every q', then every omega q.
    modal::RingDown rings;
    rings.eigenvalues = held.eigenvalues;
    rings.decay_rates = held.decay_rates;
    rings.excitation = Eigen::VectorXd::LinSpaced(n, 1, 2);
    rings.readout.velocity.setZero(2 * n, n);
    rings.readout.displacement.setZero(2 * n, n);
    rings.readout.velocity.topRows(n).setIdentity();
    for (int i = 0; i < n; ++i) {
      rings.readout.displacement(n + i, i) =
          std::sqrt(held.eigenvalues[static_cast<std::size_t>(i)]);
    }
    rings.readout.delays.assign(static_cast<std::size_t>(2 * n), 0.0);
    const modal::RingDown answer = support::coupled_ring_down(*modes, rings);
    double before = rings.excitation.squaredNorm();
    const double start = before;
    for (int k = 0; k < 40; ++k) {
      const double energy = value_at(answer, 0, 1e-5 * std::pow(1.3, k)).squaredNorm();
      RC_ASSERT(energy <= before + 1e-8 * start);
      before = energy;
    }
  });
}

TEST(CoupledModes, RefuseWhatTheyCannotSolve) {
  HeldModes held = random_held(3, 1, 1, 1);
  EXPECT_THROW(support::couple(held.eigenvalues, std::vector<double>{1, 2}, held.dashpots),
               core::InputError);
  EXPECT_THROW(support::couple(held.eigenvalues, held.decay_rates, Eigen::MatrixXd::Ones(2, 1)),
               core::InputError);
  EXPECT_THROW(
      support::coupled_ring_down(coupled(held), random_ring_down(random_held(4, 1, 1, 1), 1)),
      core::InputError);
  EXPECT_THROW(support::diagonal_error(coupled(held), held.eigenvalues, std::vector<double>{1.0}),
               core::InputError);
  HeldModes rigid = held;
  rigid.eigenvalues[0] = 0;
  EXPECT_THROW(support::couple(rigid.eigenvalues, rigid.decay_rates, rigid.dashpots),
               core::InputError);
  held.dashpots(0, 0) = std::nan("");
  EXPECT_THROW(support::couple(held.eigenvalues, held.decay_rates, held.dashpots),
               core::InputError);
}

}  // namespace
}  // namespace carillon::synth
