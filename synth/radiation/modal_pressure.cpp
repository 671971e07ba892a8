#include "synth/radiation/modal_pressure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace carillon::synth::radiation {

modal::Readout pressure_readout(const ModalPressure& pressure, const solvers::modes::Modes& modes,
                                std::span<const double> decay_rates) {
  if (decay_rates.size() != modes.size()) {
    throw core::InputError(
        fmt::format("radiation: {} decay rates for {} modes", decay_rates.size(), modes.size()));
  }
  modal::Readout readout;
  readout.unit = "Pa";
  readout.delays = pressure.delays;
  readout.acceleration = pressure.pressure.real();
  readout.velocity = Eigen::MatrixXd::Zero(pressure.pressure.rows(), pressure.pressure.cols());
  readout.force_rate = readout.velocity;
  for (std::size_t mode = 0; mode < modes.size(); ++mode) {
    const auto m = static_cast<Eigen::Index>(mode);
    const double omega = std::sqrt(modes.eigenvalues[mode]);
    if (omega == 0) continue;
    const Eigen::VectorXd quadrature = pressure.pressure.col(m).imag();
    // Im P q'''/ omega, with q''' from the equation of motion.
    readout.acceleration.col(m) -= 2 * std::min(decay_rates[mode] / omega, 1.0) * quadrature;
    readout.velocity.col(m) = -omega * quadrature;
    readout.force_rate.col(m) = quadrature / omega;
  }
  return readout;
}

std::vector<double> wavenumbers(const solvers::modes::Modes& modes) {
  if (!modes.shapes.values().allFinite()) throw core::InputError("a mode shape is not finite");
  std::vector<double> numbers;
  for (const double eigenvalue : modes.eigenvalues) {
    if (!(eigenvalue >= 0) || !std::isfinite(eigenvalue)) {
      throw core::InputError(
          fmt::format("an eigenvalue must be finite and not negative, not {}", eigenvalue));
    }
    numbers.push_back(std::sqrt(eigenvalue) / modal::speed_of_sound);
  }
  return numbers;
}

}  // namespace carillon::synth::radiation
