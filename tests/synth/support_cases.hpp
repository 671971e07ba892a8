#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <span>
#include <unsupported/Eigen/MatrixFunctions>
#include <vector>

#include "synth/modal/modal_response.hpp"
#include "synth/modal/ring_down.hpp"
#include "synth/support/diagonal_error.hpp"
#include "synth/support/supports.hpp"

namespace carillon::synth {

/// Modes with their own damping, and what holds them: q'' + (2 diag(d) + L L^T) q' + Lambda q = f.
struct HeldModes {
  std::vector<double> eigenvalues;
  std::vector<double> decay_rates;
  Eigen::MatrixXd dashpots;

  Eigen::MatrixXd damping() const {
    Eigen::MatrixXd c = dashpots * dashpots.transpose();
    for (std::size_t i = 0; i < decay_rates.size(); ++i) {
      c(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) += 2 * decay_rates[i];
    }
    return c;
  }
  /// Scale of displacements [1/s]: without it the matrix has entries from 1 to lambda, and neither
  /// eigenvalues nor exponentials keep their digits.
  static constexpr double scale = 1e4;
  /// Of the state (scale q, q'), straight from the equation.
  Eigen::MatrixXd state_matrix() const {
    const auto n = static_cast<Eigen::Index>(eigenvalues.size());
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(2 * n, 2 * n);
    a.topRightCorner(n, n) = scale * Eigen::MatrixXd::Identity(n, n);
    a.bottomLeftCorner(n, n) =
        -Eigen::MatrixXd(Eigen::Map<const Eigen::VectorXd>(eigenvalues.data(), n).asDiagonal()) /
        scale;
    a.bottomRightCorner(n, n) = -damping();
    return a;
  }
};

/// Modes from 100 Hz to 10 kHz with ceramic's damping, held by `contacts` dashpots of some 1/s.
inline HeldModes random_held(int n, int contacts, double strength, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  std::normal_distribution<double> normal;
  HeldModes held;
  for (int i = 0; i < n; ++i) {
    const double omega = 2 * std::numbers::pi * 100 * std::pow(100.0, unit(random));
    held.eigenvalues.push_back(omega * omega);
  }
  std::sort(held.eigenvalues.begin(), held.eigenvalues.end());
  for (const double lambda : held.eigenvalues) {
    held.decay_rates.push_back((6 + 1e-7 * lambda) / 2);
  }
  held.dashpots.resize(n, contacts);
  for (double& entry : held.dashpots.reshaped()) entry = std::sqrt(strength) * normal(random);
  return held;
}

/// The diagonal answer from the factor L itself.
inline std::vector<double> diagonal_rates(std::span<const double> decay_rates,
                                          const Eigen::MatrixXd& dashpots) {
  std::vector<double> rates(decay_rates.begin(), decay_rates.end());
  support::add_support_damping(rates, dashpots.rowwise().squaredNorm(), 1, 1);
  return rates;
}

/// State (q, q') at each time of modes at rest under excitation times the raised cosine of unit
/// impulse, by matrix exponentials: the force is a constant and a turning pair of the state.
inline std::vector<Eigen::VectorXd> exact_states(const HeldModes& held,
                                                 const Eigen::VectorXd& excitation,
                                                 double contact_time,
                                                 std::span<const double> times) {
  const Eigen::MatrixXd a = held.state_matrix();
  const Eigen::Index size = a.rows(), n = size / 2;
  Eigen::MatrixXd driven = Eigen::MatrixXd::Zero(size + 3, size + 3);
  driven.topLeftCorner(size, size) = a;
  driven.block(n, size, n, 1) = excitation / contact_time;
  driven.block(n, size + 1, n, 1) = -excitation / contact_time;
  const double turn = 2 * std::numbers::pi / contact_time;
  driven(size + 1, size + 2) = -turn;
  driven(size + 2, size + 1) = turn;
  Eigen::VectorXd rest = Eigen::VectorXd::Zero(size + 3);
  rest[size] = rest[size + 1] = 1;
  std::vector<Eigen::VectorXd> states;
  for (const double t : times) {
    const Eigen::VectorXd pushed = (driven * std::min(t, contact_time)).exp() * rest;
    Eigen::VectorXd state = pushed.head(size);
    if (t > contact_time) state = (a * (t - contact_time)).exp() * state;
    state.head(n) /= HeldModes::scale;
    states.push_back(state);
  }
  return states;
}

/// Rows of a ring-down at a time, in double precision.
inline Eigen::VectorXd value_at(const modal::RingDown& rings, double contact_time, double t) {
  const modal::Readout& readout = rings.readout;
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(readout.delays.size()));
  for (std::size_t i = 0; i < rings.eigenvalues.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    const modal::ModalResponse response(rings.eigenvalues[i], rings.decay_rates[i], contact_time);
    const modal::ModalMotion motion =
        t <= contact_time ? response.during_contact(t) : response.after_contact(t - contact_time);
    const auto add = [&](const Eigen::MatrixXd& gains, double value) {
      if (gains.size() > 0) sum += rings.excitation[column] * value * gains.col(column);
    };
    add(readout.displacement, motion.displacement);
    add(readout.velocity, motion.velocity);
    add(readout.acceleration, motion.acceleration);
  }
  return sum;
}

/// Poles of oscillators, sorted by imaginary part, then real part; both of each.
inline std::vector<std::complex<double>> poles_of(std::span<const double> eigenvalues,
                                                  std::span<const double> decay_rates) {
  std::vector<std::complex<double>> poles;
  for (std::size_t i = 0; i < eigenvalues.size(); ++i) {
    const double d = decay_rates[i];
    const std::complex<double> root = std::sqrt(std::complex<double>(d * d - eigenvalues[i]));
    poles.push_back(-d + root);
    poles.push_back(-d - root);
  }
  return poles;
}

/// Largest distance of a pole from the nearest of others, relative to its size.
inline double worst_pole(const std::vector<std::complex<double>>& poles,
                         const std::vector<std::complex<double>>& others) {
  double worst = poles.size() == others.size() ? 0 : 1e9;
  for (const auto& pole : poles) {
    double best = 1e300;
    for (const auto& other : others) best = std::min(best, std::abs(pole - other));
    worst = std::max(worst, best / std::abs(pole));
  }
  return worst;
}

inline std::vector<std::complex<double>> eigenvalues_of(const Eigen::MatrixXd& matrix) {
  const Eigen::VectorXcd values = Eigen::EigenSolver<Eigen::MatrixXd>(matrix, false).eigenvalues();
  return {values.begin(), values.end()};
}

/// One line for people.
inline std::string describe(const support::DiagonalError& error) {
  if (error.matched == 0) {
    return fmt::format("diagonal damping: none of {} modes can be compared", error.modes);
  }
  return fmt::format(
      "diagonal damping is off by up to {:.3g} % in decay rate (mode {}) and {:.3g} cents in pitch "
      "(mode {}); {} of {} modes compared",
      100 * error.decay_rate, error.worst_decay + 1, error.cents, error.worst_pitch + 1,
      error.matched, error.modes);
}

}  // namespace carillon::synth
