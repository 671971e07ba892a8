#include "eval/features/detail/tone_equations.hpp"

#include <Eigen/Dense>
#include <cmath>

namespace carillon::eval::features {

namespace {

using Complex = std::complex<double>;
using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

}  // namespace

Residual::Residual(const ToneFit& of, BinRange bins) : fit(&of), range(bins) {
  values.reserve(bins.size());
  weights.reserve(bins.size());
  for (std::size_t i = 0; i < bins.size(); ++i) {
    values.push_back(of.residual[bins.at(i)]);
    weights.push_back(std::sqrt(2 * static_cast<double>(bins.step) / of.noise[bins.at(i)]));
  }
}

double Residual::chi_squared() const {
  double sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    sum += weights[i] * weights[i] * std::norm(values[i]);
  }
  return sum;
}

Vector Residual::weighted() const {
  Vector out(static_cast<Eigen::Index>(2 * values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) {
    out(static_cast<Eigen::Index>(2 * i)) = weights[i] * values[i].real();
    out(static_cast<Eigen::Index>(2 * i + 1)) = weights[i] * values[i].imag();
  }
  return out;
}

Matrix jacobian_of(const Residual& residual, std::span<const Tone> tones, std::size_t columns) {
  const std::size_t size = residual.range.size();
  std::vector<Complex> derivatives(4 * size);
  Matrix jacobian(static_cast<Eigen::Index>(2 * size),
                  static_cast<Eigen::Index>(columns * tones.size()));
  for (std::size_t t = 0; t < tones.size(); ++t) {
    residual.fit->grid->derivatives(tones[t], residual.range, derivatives);
    for (std::size_t c = 0; c < columns; ++c) {
      double* out = jacobian.col(static_cast<Eigen::Index>(columns * t + c)).data();
      const Complex* column = derivatives.data() + c * size;
      for (std::size_t i = 0; i < size; ++i) {
        out[2 * i] = residual.weights[i] * column[i].real();
        out[2 * i + 1] = residual.weights[i] * column[i].imag();
      }
    }
  }
  return jacobian;
}

Normal normal_equations(const Matrix& jacobian, const Vector& right) {
  Normal normal{Matrix::Zero(jacobian.cols(), jacobian.cols()), jacobian.transpose() * right};
  normal.information.selfadjointView<Eigen::Lower>().rankUpdate(jacobian.transpose());
  normal.information = normal.information.selfadjointView<Eigen::Lower>();
  return normal;
}

Normal normal_equations(const Residual& residual, std::span<const Tone> tones) {
  return normal_equations(jacobian_of(residual, tones, 4), residual.weighted());
}

Matrix covariance_of(const Matrix& information) {
  const Vector scale = information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Matrix scaled = scale.asDiagonal() * information * scale.asDiagonal();
  const Matrix inverse = scaled.ldlt().solve(Matrix::Identity(scaled.rows(), scaled.cols()));
  return scale.asDiagonal() * inverse * scale.asDiagonal();
}

}  // namespace carillon::eval::features
