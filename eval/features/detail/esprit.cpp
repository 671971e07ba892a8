#include "eval/features/detail/esprit.hpp"

#include <Eigen/Dense>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace carillon::eval::features {

namespace {

using Complex = std::complex<double>;
using ComplexMatrix = Eigen::MatrixXcd;

constexpr std::size_t window_steps = 8;

/// Four-term Blackman-Harris window (Harris 1978): side lobes at -92 dB.
std::vector<double> blackman_harris(std::size_t count) {
  std::vector<double> window(count);
  for (std::size_t j = 0; j < count; ++j) {
    const double t =
        2 * std::numbers::pi * (static_cast<double>(j) + 0.5) / static_cast<double>(count);
    window[j] =
        0.35875 - 0.48829 * std::cos(t) + 0.14128 * std::cos(2 * t) - 0.01168 * std::cos(3 * t);
  }
  return window;
}

/// Poles of the signal space that `order` columns span.
std::vector<Complex> poles(const ComplexMatrix& space, Eigen::Index order) {
  const Eigen::Index rows = space.rows() - 1;
  const ComplexMatrix upper = space.topLeftCorner(rows, order);
  const ComplexMatrix lower = space.bottomLeftCorner(rows, order);
  const ComplexMatrix normal = upper.adjoint() * upper;
  const ComplexMatrix shift = normal.ldlt().solve(upper.adjoint() * lower);
  const Eigen::ComplexEigenSolver<ComplexMatrix> solver(shift, false);
  return {solver.eigenvalues().begin(), solver.eigenvalues().end()};
}

/// Amplitudes of poles in the band, by least squares.
Eigen::VectorXcd amplitudes(const std::vector<Complex>& z, const std::vector<Complex>& values) {
  const auto rows = static_cast<Eigen::Index>(values.size());
  ComplexMatrix powers(rows, static_cast<Eigen::Index>(z.size()));
  for (Eigen::Index k = 0; k < powers.cols(); ++k) {
    Complex power = 1;
    for (Eigen::Index n = 0; n < rows; ++n, power *= z[static_cast<std::size_t>(k)]) {
      powers(n, k) = power;
    }
  }
  const Eigen::Map<const Eigen::VectorXcd> right(values.data(), rows);
  return (powers.adjoint() * powers).ldlt().solve(powers.adjoint() * right);
}

}  // namespace

Band take_band(std::span<const double> samples, double centre, std::size_t step,
               std::size_t maximum) {
  const std::size_t length = window_steps * step;
  Band band{{}, centre, step};
  if (samples.size() < length) return band;
  const std::size_t count = std::min(maximum, (samples.size() - length) / step + 1);
  std::vector<double> taps_re(length), taps_im(length);
  const std::vector<double> window = blackman_harris(length);
  for (std::size_t j = 0; j < length; ++j) {
    taps_re[j] = window[j] * std::cos(centre * static_cast<double>(j));
    taps_im[j] = -window[j] * std::sin(centre * static_cast<double>(j));
  }
  using Row = Eigen::Map<const Eigen::VectorXd>;
  const Row re(taps_re.data(), static_cast<Eigen::Index>(length));
  const Row im(taps_im.data(), static_cast<Eigen::Index>(length));
  for (std::size_t k = 0; k < count; ++k) {
    const Row part(samples.data() + k * step, static_cast<Eigen::Index>(length));
    const double turn = -centre * static_cast<double>(k * step);
    band.values.push_back(Complex(re.dot(part), im.dot(part)) * std::polar(1.0, turn));
  }
  return band;
}

std::vector<Complex> esprit_rates(const Band& band, double noise, std::size_t max_orders) {
  const auto count = static_cast<Eigen::Index>(band.values.size());
  const Eigen::Index rows = count / 2, columns = count - rows + 1;
  if (rows < 4) return {};
  ComplexMatrix hankel(rows, columns);
  for (Eigen::Index i = 0; i < rows; ++i) {
    for (Eigen::Index j = 0; j < columns; ++j) {
      hankel(i, j) = band.values[static_cast<std::size_t>(i + j)];
    }
  }
  // The signal space from the covariance: half the digits of a singular value decomposition, in a
  // tenth of the time. What comes out of it is refined against the samples anyway.
  const Eigen::SelfAdjointEigenSolver<ComplexMatrix> spectrum(hankel * hankel.adjoint());
  const ComplexMatrix space = spectrum.eigenvectors().rowwise().reverse();
  const double floor = 9 * noise * noise * static_cast<double>(columns);
  Eigen::Index order = 0;
  for (Eigen::Index k = rows; k-- > 0 && spectrum.eigenvalues()(k) > floor;) ++order;
  if (order == 0) return {};
  const Eigen::Index maximum =
      std::min<Eigen::Index>(rows / 2, static_cast<Eigen::Index>(max_orders));
  order = std::min(order + 2, maximum);
  const std::vector<Complex> found = poles(space, order);
  const std::vector<Complex> again = poles(space, std::min(order + 3, rows - 1));

  const double step = static_cast<double>(band.step);
  const double span = static_cast<double>(count);
  std::vector<Complex> kept;
  for (const Complex& z : found) {
    if (!(std::abs(z) > 1e-3)) continue;
    const Complex rate = std::log(z);  // per value, relative to the centre
    if (rate.real() > 1 / span) continue;
    if (std::abs(rate.imag()) > 0.8 * std::numbers::pi) continue;
    double nearest = 1e300;
    for (const Complex& other : again)
      nearest = std::min(nearest, std::abs(std::log(other) - rate));
    if (nearest > 0.3 * std::abs(rate.real()) + 0.5 / span) continue;
    kept.push_back(z);
  }
  if (kept.empty()) return {};
  const Eigen::VectorXcd size = amplitudes(kept, band.values);
  std::vector<std::size_t> rank(kept.size());
  for (std::size_t k = 0; k < rank.size(); ++k) rank[k] = k;
  const auto strength = [&](std::size_t k) {
    const double decay = std::max(1 / span, -std::log(std::abs(kept[k])));
    return std::norm(size(static_cast<Eigen::Index>(k))) / decay;
  };
  std::sort(rank.begin(), rank.end(),
            [&](std::size_t a, std::size_t b) { return strength(a) > strength(b); });
  std::vector<Complex> rates;
  for (const std::size_t k : rank) {
    rates.push_back(std::log(kept[k]) / step + Complex(0, band.centre));
  }
  return rates;
}

}  // namespace carillon::eval::features
