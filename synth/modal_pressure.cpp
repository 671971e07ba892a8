#include "synth/modal_pressure.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/error.hpp"

namespace carillon::synth {

Readout pressure_readout(const ModalPressure& pressure, const solvers::Modes& modes,
                         std::span<const double> decay_rates) {
  if (decay_rates.size() != modes.size()) {
    throw core::InputError(
        fmt::format("radiation: {} decay rates for {} modes", decay_rates.size(), modes.size()));
  }
  Readout readout;
  readout.unit = "Pa";
  readout.delays = pressure.delays;
  readout.acceleration = pressure.pressure.real();
  readout.velocity = Eigen::MatrixXd::Zero(pressure.pressure.rows(), pressure.pressure.cols());
  readout.displacement = readout.velocity;
  for (std::size_t mode = 0; mode < modes.size(); ++mode) {
    const auto m = static_cast<Eigen::Index>(mode);
    const double eigenvalue = modes.eigenvalues[mode], decay = decay_rates[mode];
    const double damped = std::sqrt(std::max(0.0, eigenvalue - decay * decay));
    if (damped == 0) continue;
    for (Eigen::Index row = 0; row < pressure.pressure.rows(); ++row) {
      const std::complex<double> per_velocity =
          std::complex<double>(0, pressure.pressure(row, m).imag()) *
          std::complex<double>(-decay, damped);
      add_transfer(readout, row, m, per_velocity, eigenvalue, decay);
    }
  }
  return readout;
}

std::vector<double> wavenumbers(const solvers::Modes& modes) {
  if (!modes.shapes.allFinite()) throw core::InputError("a mode shape is not finite");
  std::vector<double> numbers;
  for (const double eigenvalue : modes.eigenvalues) {
    if (!(eigenvalue >= 0) || !std::isfinite(eigenvalue)) {
      throw core::InputError(
          fmt::format("an eigenvalue must be finite and not negative, not {}", eigenvalue));
    }
    numbers.push_back(std::sqrt(eigenvalue) / kSoundSpeed);
  }
  return numbers;
}

}  // namespace carillon::synth
