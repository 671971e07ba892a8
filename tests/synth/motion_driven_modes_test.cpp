#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

#include "core/error.hpp"
#include "synth/contact/hertz_pulse.hpp"
#include "synth/motion/detail/driven_modes.hpp"
#include "synth/motion/detail/slow_rates.hpp"
#include "tests/synth/random_rings.hpp"

namespace carillon::synth {
namespace {

constexpr double audio_rate = 44100;

motion::DrivenGains still_gains(const modal::Readout& readout) {
  return {&readout, &readout, 0, 0};
}

/// Rows of a body struck `delay` after the first sample, in blocks of a size.
Eigen::MatrixXd struck(const modal::RingDown& rings, const modal::ContactForce& force, double delay,
                       Eigen::Index count, Eigen::Index block) {
  motion::DrivenModes modes(rings.eigenvalues, rings.decay_rates, audio_rate);
  modes.strike(rings.excitation, force, delay);
  Eigen::MatrixXd rows =
      Eigen::MatrixXd::Zero(count, static_cast<Eigen::Index>(rings.readout.delays.size()));
  for (Eigen::Index done = 0; done < count; done += block) {
    const Eigen::Index size = std::min(block, count - done);
    modes.render({}, still_gains(rings.readout), rows.middleRows(done, size));
  }
  return rows;
}

// Strikes shorter and longer than samples, at any time, of modes near and beyond critical damping.
TEST(DrivenModes, AStrikeIsThatOfSynthesize) {
  constexpr Eigen::Index sample_count = 5000;
  for (const bool pressure : {false, true}) {
    modal::RingDown rings = random_rings(61, 7, pressure);
    rings.readout.delays.assign(rings.readout.delays.size(), 0.0);
    rings.decay_rates[1] = std::sqrt(rings.eigenvalues[1]) * 0.9999;
    rings.decay_rates[2] = std::sqrt(rings.eigenvalues[2]) * 1.7;
    if (pressure) {
      rings.readout.velocity = -300 * rings.readout.acceleration;
      rings.readout.force_rate = 1e-4 * rings.readout.acceleration;
    }
    for (const double duration : {0.0, 2e-6, 1.3e-5, 4e-5, 3e-4, 6e-3}) {
      for (const bool sampled : {false, true}) {
        const modal::ContactForce force =
            sampled ? contact::hertz_pulse(duration) : modal::ContactForce{duration};
        for (const double delay : {0.0, 0.01234567}) {
          modal::RingDown late = rings;
          for (double& row : late.readout.delays) row = delay;
          const auto expected = modal::synthesize(late, force, audio_rate, sample_count);
          const Eigen::MatrixXd found = struck(rings, force, delay, sample_count, 700);
          double peak = 0, worst = 0;
          for (Eigen::Index row = 0; row < found.cols(); ++row) {
            for (Eigen::Index n = 0; n < sample_count; ++n) {
              const double value = expected[static_cast<std::size_t>(row * sample_count + n)];
              peak = std::max(peak, std::abs(value));
              worst = std::max(worst, std::abs(value - found(n, row)));
            }
          }
          EXPECT_LT(worst, 1e-6 * peak) << duration << ' ' << sampled << ' ' << delay;
        }
      }
    }
  }
}

/// One mode at rest under a force of straight lines between samples, by matrix exponentials of
/// (q, q', F, slope): at each sample, (q, q').
Eigen::MatrixX2d driven_exactly(double lambda, const std::vector<double>& decay_rates,
                                const Eigen::VectorXd& force) {
  const double step = 1 / audio_rate;
  Eigen::MatrixX2d motion(force.size() - 1, 2);
  Eigen::Vector4d state = Eigen::Vector4d::Zero();
  for (Eigen::Index n = 0; n + 1 < force.size(); ++n) {
    motion.row(n) = state.head<2>().transpose();
    state[2] = force[n];
    state[3] = (force[n + 1] - force[n]) / step;
    Eigen::Matrix4d a = Eigen::Matrix4d::Zero();
    a(0, 1) = 1;
    a(1, 0) = -lambda;
    a(1, 1) = -2 * decay_rates[static_cast<std::size_t>(n)];
    a(1, 2) = 1;
    a(2, 3) = 1;
    // Scaled by omega, so that entries are alike.
    const double omega = std::sqrt(lambda);
    const Eigen::Vector4d scale(omega, 1, step, step * step);
    const Eigen::Matrix4d alike = scale.asDiagonal() * a * scale.cwiseInverse().asDiagonal();
    const Eigen::Matrix4d whole = (alike * step).exp();
    state = scale.cwiseInverse().asDiagonal() * (whole * (scale.asDiagonal() * state));
  }
  return motion;
}

TEST(DrivenModes, AreExactUnderForcesOfStraightLinesAndChangingDamping) {
  constexpr Eigen::Index block_size = 150, block_count = 3;
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  Eigen::VectorXd force(block_size * block_count + 1);
  for (double& value : force) value = normal(random);
  for (const double damping : {0.001, 0.2, 1.0, 3.0}) {
    const std::vector<double> eigenvalues = {
        std::pow(2 * M_PI * 80, 2), std::pow(2 * M_PI * 3e3, 2), std::pow(2 * M_PI * 21e3, 2)};
    modal::Readout readout;
    readout.delays.assign(9, 0.0);
    readout.displacement = readout.velocity = readout.acceleration = Eigen::MatrixXd::Zero(9, 3);
    for (int i = 0; i < 3; ++i) {
      readout.displacement(i, i) = readout.velocity(3 + i, i) = readout.acceleration(6 + i, i) = 1;
    }
    const auto rates = [&](Eigen::Index block) {
      std::vector<double> d;
      for (const double lambda : eigenvalues) {
        d.push_back(damping * std::sqrt(lambda) * (block == 1 ? 1.4 : 1));
      }
      // One keeps its own, so that not every step is made anew.
      d[1] = damping * std::sqrt(eigenvalues[1]);
      return d;
    };
    motion::DrivenModes modes(eigenvalues, rates(0), audio_rate);
    if (modes.modes() < 3) continue;
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(block_size * block_count, 9);
    for (Eigen::Index block = 0; block < block_count; ++block) {
      modes.set_decay_rates(rates(block));
      motion::Drive drive;
      drive.begin = drive.end = Eigen::MatrixX3d::Zero(3, 3);
      drive.begin.col(1) = drive.end.col(1) = Eigen::Vector3d(1, -2, 3);
      drive.forces = Eigen::Matrix3Xd::Zero(3, block_size + 1);
      drive.forces.row(1) = force.segment(block * block_size, block_size + 1).transpose();
      modes.render({&drive, 1}, still_gains(readout),
                   rows.middleRows(block * block_size, block_size));
    }
    for (int i = 0; i < 3; ++i) {
      std::vector<double> d;
      for (Eigen::Index n = 0; n < block_size * block_count; ++n) {
        d.push_back(rates(n / block_size)[static_cast<std::size_t>(i)]);
      }
      const double by = i == 0 ? 1 : i == 1 ? -2 : 3;
      const double lambda = eigenvalues[static_cast<std::size_t>(i)];
      const Eigen::MatrixX2d exact = by * driven_exactly(lambda, d, force);
      const Eigen::VectorXd accelerations =
          by * force.head(block_size * block_count) - lambda * exact.col(0) -
          (2 * Eigen::Map<Eigen::VectorXd>(d.data(), block_size * block_count).array() *
           exact.col(1).array())
              .matrix();
      const auto off = [](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
        return (a - b).cwiseAbs().maxCoeff() / b.cwiseAbs().maxCoeff();
      };
      EXPECT_LT(off(rows.col(i), exact.col(0)), 1e-9) << damping << ' ' << i;
      EXPECT_LT(off(rows.col(3 + i), exact.col(1)), 1e-9) << damping << ' ' << i;
      EXPECT_LT(off(rows.col(6 + i), accelerations), 1e-9) << damping << ' ' << i;
    }
  }
}

// Places and gains go in straight lines over a block: what comes out is the same however the
// straight line is cut into blocks.
TEST(DrivenModes, PlacesAndGainsThatMoveDoNotKnowOfBlocks) {
  EXPECT_TRUE(rc::check("any cut of the same course", [] {
    const auto count = *rc::gen::inRange<Eigen::Index>(2, 400);
    const modal::RingDown rings = random_rings(13, 5, true);
    modal::Readout other = rings.readout;
    other.acceleration = rings.readout.acceleration.rowwise().reverse();
    other.displacement = 1e4 * rings.readout.acceleration;
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    Eigen::MatrixX3d from(13, 3), to(13, 3);
    for (double& value : from.reshaped()) value = normal(random);
    for (double& value : to.reshaped()) value = normal(random);
    Eigen::Matrix3Xd forces(3, count + 1);
    for (double& value : forces.reshaped()) value = normal(random);
    const auto at = [&](Eigen::Index n) -> Eigen::MatrixX3d {
      const double fraction = static_cast<double>(n) / static_cast<double>(count);
      return from + fraction * (to - from);
    };
    const auto render = [&](const std::vector<Eigen::Index>& cuts) {
      motion::DrivenModes modes(rings.eigenvalues, rings.decay_rates, audio_rate);
      Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(count, 2);
      for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
        const Eigen::Index begin = cuts[i], size = cuts[i + 1] - begin;
        const motion::Drive drive = {at(begin), at(begin + size),
                                     forces.middleCols(begin, size + 1)};
        const double whole = static_cast<double>(count);
        modes.render({&drive, 1},
                     {&rings.readout, &other, static_cast<double>(begin) / whole,
                      static_cast<double>(begin + size) / whole},
                     rows.middleRows(begin, size));
      }
      return rows;
    };
    const Eigen::Index cut = *rc::gen::inRange<Eigen::Index>(1, count);
    const Eigen::MatrixXd whole = render({0, count}), two = render({0, cut, count});
    RC_ASSERT((whole - two).cwiseAbs().maxCoeff() <= 1e-10 * whole.cwiseAbs().maxCoeff());
  }));
}

// Pressure of modes far above the force: that of P(s) s^2 / (s^2 + 2 d s + lambda), in which P =
// Re P + s Im P / omega, not that of the gains without the force's rate, 50 times as much.
TEST(DrivenModes, PressureOfForcesBelowTheModesIsThatOfTheTransferFunction) {
  const std::vector<double> eigenvalues = {std::pow(2 * M_PI * 2000, 2),
                                           std::pow(2 * M_PI * 5200, 2)};
  const std::vector<double> decay_rates = {15, 40};
  const std::complex<double> pressure[2] = {{0.3, 1.1}, {-0.8, 0.4}};
  const double shape[2] = {1.5, -0.7};
  modal::Readout readout;
  readout.delays = {0.0};
  readout.acceleration = readout.velocity = readout.force_rate = Eigen::MatrixXd::Zero(1, 2);
  for (int i = 0; i < 2; ++i) {
    const double omega = std::sqrt(eigenvalues[static_cast<std::size_t>(i)]);
    const double d = decay_rates[static_cast<std::size_t>(i)];
    readout.acceleration(0, i) = pressure[i].real() - 2 * d / omega * pressure[i].imag();
    readout.velocity(0, i) = -omega * pressure[i].imag();
    readout.force_rate(0, i) = pressure[i].imag() / omega;
  }
  constexpr Eigen::Index sample_count = 20000, block_size = 450;
  for (const double frequency : {60.0, 125.0, 400.0}) {
    const double turn = 2 * M_PI * frequency / audio_rate;
    Eigen::Matrix3Xd force = Eigen::Matrix3Xd::Zero(3, sample_count + 1);
    for (Eigen::Index n = 0; n <= sample_count; ++n) {
      const double edge = std::min<double>(1, double(std::min(n, sample_count - n)) / 6000);
      force(2, n) = std::sin(turn * double(n)) * std::pow(std::sin(M_PI / 2 * edge), 2);
    }
    motion::DrivenModes modes(eigenvalues, decay_rates, audio_rate);
    const auto rates = motion::slow_rates(force, audio_rate, modes.octaves());
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(sample_count, 1);
    for (Eigen::Index done = 0; done < sample_count; done += block_size) {
      const Eigen::Index size = std::min(block_size, sample_count - done);
      motion::Drive drive;
      drive.begin = drive.end = Eigen::MatrixX3d::Zero(2, 3);
      drive.begin.col(2) = drive.end.col(2) = Eigen::Vector2d(shape[0], shape[1]);
      drive.forces = force.middleCols(done, size + 1);
      for (const auto& rate : rates) {
        drive.slow_rates.push_back(rate.cols() == 0 ? rate : rate.middleCols(done, size));
      }
      modes.render({&drive, 1}, still_gains(readout), rows.middleRows(done, size));
    }
    const std::complex<double> s(0, 2 * M_PI * frequency);
    std::complex<double> expected;
    for (int i = 0; i < 2; ++i) {
      const double lambda = eigenvalues[static_cast<std::size_t>(i)];
      const double d = decay_rates[static_cast<std::size_t>(i)];
      const std::complex<double> p =
          pressure[i].real() + s * pressure[i].imag() / std::sqrt(lambda);
      expected += p * shape[i] * s * s / (s * s + 2 * d * s + lambda);
    }
    double worst = 0;
    for (Eigen::Index n = 8000; n < 12000; ++n) {
      const double value = (expected * std::polar(1.0, turn * double(n))).imag();
      worst = std::max(worst, std::abs(rows(n, 0) - value));
    }
    EXPECT_LT(worst, 0.02 * std::abs(expected)) << frequency;
  }
}

TEST(DrivenModes, RestWhenTheyHaveDecayedAndCostNothing) {
  modal::RingDown rings = random_rings(40, 2, false);
  for (double& rate : rings.decay_rates) rate += 200;
  motion::DrivenModes modes(rings.eigenvalues, rings.decay_rates, audio_rate);
  const auto render = [&](Eigen::Index count) {
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(count, 1);
    modes.render({}, still_gains(rings.readout), rows);
    return rows;
  };
  EXPECT_TRUE(modes.resting());
  EXPECT_TRUE(render(1000).isZero(0));
  EXPECT_EQ(modes.mode_samples(), 0u);
  modes.strike(rings.excitation, {1e-3}, 0.009999);
  EXPECT_EQ(modes.until_strike(), 441u);
  const double peak = render(44100).cwiseAbs().maxCoeff();
  EXPECT_TRUE(modes.resting());
  const std::uint64_t spent = modes.mode_samples();
  EXPECT_GT(spent, 40u * 1000);
  // ln(1e8) / 200 = 0.09 s of 40 modes, those that go earlier taken off.
  EXPECT_LT(spent, 40u * 6500);
  EXPECT_TRUE(render(44100).isZero(0));
  EXPECT_EQ(modes.mode_samples(), spent);
  EXPECT_GT(peak, 0);
}

TEST(DrivenModes, RefuseWhatDoesNotFit) {
  const modal::RingDown rings = random_rings(5, 1, false);
  motion::DrivenModes modes(rings.eigenvalues, rings.decay_rates, audio_rate);
  EXPECT_THROW(modes.set_decay_rates(std::vector<double>(4, 1.0)), core::InputError);
  EXPECT_THROW(modes.set_decay_rates(std::vector<double>(5, std::nan(""))), core::InputError);
  EXPECT_THROW(modes.strike(Eigen::VectorXd::Ones(4), {1e-3}, 0), core::InputError);
  EXPECT_THROW(modes.strike(rings.excitation, {1e-3}, -1), core::InputError);
  EXPECT_THROW(modes.strike(rings.excitation, {60}, 0), core::InputError);
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(10, 2);
  EXPECT_THROW(modes.render({}, still_gains(rings.readout), rows), core::InputError);
  motion::Drive drive = {Eigen::MatrixX3d::Ones(5, 3), Eigen::MatrixX3d::Ones(5, 3),
                         Eigen::Matrix3Xd::Ones(3, 10)};
  EXPECT_THROW(modes.render({&drive, 1}, still_gains(rings.readout), rows.leftCols(1)),
               core::InputError);
  drive.forces = Eigen::Matrix3Xd::Constant(3, 11, std::nan(""));
  EXPECT_THROW(modes.render({&drive, 1}, still_gains(rings.readout), rows.leftCols(1)),
               core::InputError);
}

}  // namespace
}  // namespace carillon::synth
