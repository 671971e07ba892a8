#include "eval/features/cramer_rao.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "core/error.hpp"

namespace carillon::eval::features {

namespace {

constexpr Eigen::Index chunk = 2048;

/// Derivatives of the sum by the frequency, decay rate, log-amplitude and phase of every mode, over
/// the noise: rows from sample `first` on.
void fill(Eigen::MatrixXd& jacobian, std::span<const Feature> modes, const Observation& seen,
          Eigen::Index first) {
  for (std::size_t m = 0; m < modes.size(); ++m) {
    const Feature& mode = modes[m];
    const auto column = static_cast<Eigen::Index>(4 * m);
    const std::complex<double> rate(-mode.decay_rate, 2 * std::numbers::pi * mode.frequency);
    for (Eigen::Index row = 0; row < jacobian.rows(); ++row) {
      const double t = seen.begin + static_cast<double>(first + row) / seen.sample_rate;
      const std::complex<double> value =
          std::polar(mode.amplitude / seen.noise, mode.phase) * std::exp(rate * t);
      jacobian(row, column) = -2 * std::numbers::pi * t * value.imag();
      jacobian(row, column + 1) = -t * value.real();
      jacobian(row, column + 2) = value.real();
      jacobian(row, column + 3) = -value.imag();
    }
  }
}

}  // namespace

std::vector<ModeBound> cramer_rao(std::span<const Feature> modes, const Observation& seen) {
  const auto samples =
      static_cast<Eigen::Index>(std::floor((seen.end - seen.begin) * seen.sample_rate));
  if (!(seen.noise > 0) || samples < 1) {
    throw core::InputError("Cramer-Rao bounds need noise and something that is observed");
  }
  const auto unknowns = static_cast<Eigen::Index>(4 * modes.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(unknowns, unknowns);
  for (Eigen::Index first = 0; first < samples; first += chunk) {
    Eigen::MatrixXd jacobian(std::min(chunk, samples - first), unknowns);
    fill(jacobian, modes, seen, first);
    information.selfadjointView<Eigen::Lower>().rankUpdate(jacobian.transpose());
  }
  // Parameters differ by powers of ten: scaled to a diagonal of ones.
  const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
  information.triangularView<Eigen::StrictlyUpper>() = information.transpose();
  information = scale.asDiagonal() * information * scale.asDiagonal();
  const Eigen::LLT<Eigen::MatrixXd> factor(information);
  if (factor.info() != Eigen::Success) {
    throw core::InputError("Cramer-Rao bounds: modes that cannot be told apart");
  }
  const Eigen::VectorXd variance =
      factor.solve(Eigen::MatrixXd::Identity(unknowns, unknowns)).diagonal();
  std::vector<ModeBound> bounds;
  for (Eigen::Index m = 0; m < unknowns; m += 4) {
    bounds.push_back(
        {scale(m) * std::sqrt(variance(m)), scale(m + 1) * std::sqrt(variance(m + 1))});
  }
  return bounds;
}

}  // namespace carillon::eval::features
