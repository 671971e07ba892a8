#pragma once

#include <Eigen/Core>
#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include "eval/features/detail/tone_fit.hpp"

namespace carillon::eval::features {

/// The residual of a fit on a range of bins, and its weights in units of the noise. Bins that are
/// skipped count as those that are not.
struct Residual {
  Residual(const ToneFit& of, BinRange bins);
  /// Adds factor times a tone.
  void add(const Tone& tone, double factor) { fit->grid->add_part(tone, factor, range, values); }
  double chi_squared() const;
  /// Real and imaginary parts, one after the other, in units of the noise.
  Eigen::VectorXd weighted() const;

  const ToneFit* fit;
  BinRange range;
  std::vector<double> weights;
  std::vector<std::complex<double>> values;
};

/// Derivatives of tones with respect to the first `columns` of their four parameters (2: amplitude;
/// 4: rate too), in units of the noise: 2 range.size() rows, columns tones.size() columns.
Eigen::MatrixXd jacobian_of(const Residual& residual, std::span<const Tone> tones,
                            std::size_t columns);

/// Normal equations of a block of tones: J^T J and J^T r in units of the noise.
struct Normal {
  Eigen::MatrixXd information;
  Eigen::VectorXd slope;
};
Normal normal_equations(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& right);
/// Of all four parameters of each tone.
Normal normal_equations(const Residual& residual, std::span<const Tone> tones);

/// The inverse of an information matrix, by its correlations: parameters differ by many powers of
/// ten.
Eigen::MatrixXd covariance_of(const Eigen::MatrixXd& information);

}  // namespace carillon::eval::features
