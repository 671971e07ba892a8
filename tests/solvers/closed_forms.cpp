#include "closed_forms.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <numbers>
#include <sstream>
#include <stdexcept>

namespace carillon::test {
namespace {

/// Integrals over [-1, 1] of normalised Legendre polynomials: derivative times derivative and
/// derivative times value.
struct LegendreIntegrals {
  Eigen::MatrixXd slope_slope, slope_value;

  explicit LegendreIntegrals(int degree) {
    // P_n' = sum over k = n-1, n-3, ... of (2 k + 1) P_k, in the normalised basis.
    const Eigen::Index n = degree + 1;
    slope_value = Eigen::MatrixXd::Zero(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index k = i - 1; k >= 0; k -= 2) {
        slope_value(i, k) = std::sqrt((2.0 * i + 1) * (2.0 * k + 1));
      }
    }
    slope_slope = slope_value * slope_value.transpose();
  }
};

struct Term {
  int component;
  std::array<int, 3> degree;
};

/// Terms of one symmetry class: displacement component c is odd along axis a when the class is,
/// the other way round along its own axis.
std::vector<Term> terms_of(const std::array<int, 3>& degrees, int parity) {
  std::vector<Term> terms;
  for (int c = 0; c < 3; ++c)
    for (int i = 0; i <= degrees[0]; ++i)
      for (int j = 0; j <= degrees[1]; ++j)
        for (int k = 0; k <= degrees[2]; ++k) {
          const std::array<int, 3> d = {i, j, k};
          bool fits = true;
          for (int a = 0; a < 3; ++a) {
            const int odd = ((parity >> a) & 1) ^ (a == c ? 1 : 0);
            fits = fits && d[static_cast<std::size_t>(a)] % 2 == odd;
          }
          if (fits) terms.push_back({c, d});
        }
  return terms;
}

}  // namespace

std::vector<double> box_frequencies(const std::array<double, 3>& sides,
                                    const std::array<int, 3>& degrees, double youngs_modulus,
                                    double poisson_ratio, double density, std::size_t count) {
  const double mu = youngs_modulus / (2 * (1 + poisson_ratio));
  const double lambda = 2 * mu * poisson_ratio / (1 - 2 * poisson_ratio);
  Eigen::Matrix<double, 6, 6> stiffness = Eigen::Matrix<double, 6, 6>::Zero();
  stiffness.topLeftCorner<3, 3>().setConstant(lambda);
  stiffness.diagonal().head<3>().array() += 2 * mu;
  stiffness.diagonal().tail<3>().setConstant(mu);
  return box_frequencies(sides, degrees, stiffness, density, count);
}

std::vector<double> box_frequencies(const std::array<double, 3>& sides,
                                    const std::array<int, 3>& degrees,
                                    const Eigen::Matrix<double, 6, 6>& stiffness, double density,
                                    std::size_t count) {
  // C_iajb by Voigt's places of its pairs.
  const auto c = [&stiffness](int i, int a, int j, int b) {
    const auto place = [](int p, int q) { return p == q ? p : 6 - p - q; };
    return stiffness(place(i, a), place(j, b));
  };
  const LegendreIntegrals integrals(*std::max_element(degrees.begin(), degrees.end()));
  std::vector<double> frequencies;
  for (int parity = 0; parity < 8; ++parity) {
    const auto terms = terms_of(degrees, parity);
    const auto n = static_cast<Eigen::Index>(terms.size());
    Eigen::MatrixXd k(n, n);
    // Integral of d_a of one term times d_b of another over the cube.
    const auto integral = [&](const Term& u, const Term& v, int a, int b) {
      double product = 1;
      for (int axis = 0; axis < 3 && product != 0; ++axis) {
        const auto s = static_cast<std::size_t>(axis);
        const int i = u.degree[s], j = v.degree[s];
        if (axis == a && axis == b) {
          product *= integrals.slope_slope(i, j);
        } else if (axis == a) {
          product *= integrals.slope_value(i, j);
        } else if (axis == b) {
          product *= integrals.slope_value(j, i);
        } else {
          product *= i == j ? 1 : 0;
        }
      }
      // From the cube of side 2 to the box.
      return product * 4 /
             (sides[static_cast<std::size_t>(a)] * sides[static_cast<std::size_t>(b)]);
    };
    for (Eigen::Index row = 0; row < n; ++row) {
      for (Eigen::Index column = 0; column <= row; ++column) {
        const auto& u = terms[static_cast<std::size_t>(row)];
        const auto& v = terms[static_cast<std::size_t>(column)];
        double sum = 0;
        for (int a = 0; a < 3; ++a) {
          for (int b = 0; b < 3; ++b) {
            const double constant = c(u.component, a, v.component, b);
            if (constant != 0) sum += constant * integral(u, v, a, b);
          }
        }
        k(row, column) = k(column, row) = sum / density;
      }
    }
    // Normalised polynomials: the mass matrix is the identity.
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(k, Eigen::EigenvaluesOnly);
    for (Eigen::Index i = 0; i < std::min<Eigen::Index>(n, 60); ++i) {
      frequencies.push_back(std::sqrt(std::max(0.0, solver.eigenvalues()[i])) /
                            (2 * std::numbers::pi));
    }
  }
  std::sort(frequencies.begin(), frequencies.end());
  frequencies.erase(frequencies.begin(), frequencies.begin() + 6);
  frequencies.resize(count);
  return frequencies;
}

std::vector<SphereMode> sphere_modes(double radius, double youngs_modulus, double poisson_ratio,
                                     double density, double max_frequency) {
  const double mu = youngs_modulus / (2 * (1 + poisson_ratio));
  const double shear_speed = std::sqrt(mu / density);
  const double slowness = std::sqrt((1 - 2 * poisson_ratio) / (2 * (1 - poisson_ratio)));
  const double ratio = 1 / (slowness * slowness) - 2;  // lambda / mu
  struct Bessel {
    double value, slope, curvature;
    Bessel(int l, double x)
        : value(std::sph_bessel(static_cast<unsigned>(l), x)),
          slope(l / x * value - std::sph_bessel(static_cast<unsigned>(l + 1), x)),
          curvature(-2 / x * slope - (1 - l * (l + 1) / (x * x)) * value) {}
  };
  // Tractions on the unit sphere of grad(phi) and curl curl(r psi) vanish together.
  const auto spheroidal = [&](int l, double eta) {
    const double xi = eta * slowness, a = xi, b = eta, ll = l * (l + 1);
    const Bessel p(l, a), q(l, b);
    const double t11 = a * a * (2 * p.curvature - ratio * p.value);
    if (l == 0) return t11;
    const double t12 = 2 * ll * (b * q.slope - q.value);
    const double t21 = 2 * (a * p.slope - p.value);
    const double t22 = b * b * q.curvature + (ll - 2) * q.value;
    return t11 * t22 - t12 * t21;
  };
  const auto torsional = [](int l, double eta) {
    const Bessel q(l, eta);
    return eta * q.slope - q.value;
  };

  std::vector<SphereMode> modes;
  const double to_frequency = shear_speed / (2 * std::numbers::pi * radius);
  const double maximum = max_frequency / to_frequency;
  const auto search = [&](char type, int l, const std::function<double(int, double)>& f) {
    constexpr double step = 2e-3;
    const auto steps = static_cast<int>(std::ceil((maximum - 0.5) / step));
    for (int k = 0; k < steps; ++k) {
      double a = 0.5 + k * step, b = a + step;
      if ((f(l, a) > 0) == (f(l, b) > 0)) continue;
      for (int i = 0; i < 60; ++i) {
        const double middle = (a + b) / 2;
        ((f(l, middle) > 0) == (f(l, a) > 0) ? a : b) = middle;
      }
      if (a <= maximum) modes.push_back({type, l, a * to_frequency});
    }
  };
  for (int l = 0; l < maximum + 3; ++l) {
    search('S', l, spheroidal);
    if (l > 0) search('T', l, torsional);
  }
  std::sort(modes.begin(), modes.end(),
            [](const SphereMode& a, const SphereMode& b) { return a.frequency < b.frequency; });
  return modes;
}

double cents(double a, double b) {
  return 1200 * std::log2(a / b);
}

std::vector<std::string> csv_column(const std::string& path, const std::string& name) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  std::vector<std::string> out;
  std::ptrdiff_t wanted = -1;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#') || line.starts_with("\"#")) continue;
    if (line.ends_with('\r')) line.pop_back();
    std::vector<std::string> cells;
    std::istringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    if (wanted < 0) {
      wanted = std::find(cells.begin(), cells.end(), name) - cells.begin();
      if (wanted == static_cast<std::ptrdiff_t>(cells.size())) {
        throw std::runtime_error(fmt::format("{} has no column {}", path, name));
      }
      continue;
    }
    if (wanted < static_cast<std::ptrdiff_t>(cells.size())) {
      out.push_back(cells[static_cast<std::size_t>(wanted)]);
    }
  }
  return out;
}

}  // namespace carillon::test
