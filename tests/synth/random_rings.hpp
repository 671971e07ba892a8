#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include "synth/modal/ring_down.hpp"

namespace carillon::synth {

/// Ring-down of modes from 50 Hz to 20 kHz with ceramic's damping and gains of both signs; with
/// pressure, two listeners of whom one is late.
inline modal::RingDown random_rings(int modes, unsigned seed, bool pressure) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  modal::RingDown rings;
  rings.excitation = Eigen::VectorXd::Ones(modes);
  const int rows = pressure ? 2 : 1;
  Eigen::MatrixXd& gains = pressure ? rings.readout.acceleration : rings.readout.velocity;
  gains.resize(rows, modes);
  for (int i = 0; i < modes; ++i) {
    const double omega = 2 * std::numbers::pi * 50 * std::pow(400.0, unit(random));
    rings.eigenvalues.push_back(omega * omega);
    rings.decay_rates.push_back((6 + 1e-7 * omega * omega) / 2);
    for (int row = 0; row < rows; ++row) gains(row, i) = unit(random) - 0.3;
  }
  rings.readout.unit = pressure ? "Pa" : "m/s";
  rings.readout.delays = pressure ? std::vector<double>{0.0, 0.00123} : std::vector<double>{0.0};
  return rings;
}

}  // namespace carillon::synth
