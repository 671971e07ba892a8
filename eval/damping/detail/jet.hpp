#pragma once

#include <Eigen/Core>
#include <cmath>

namespace carillon::eval::damping {

/// A number with its first and second derivatives by N variables (forward differentiation).
template <int N>
struct Jet {
  double value = 0;
  Eigen::Matrix<double, N, 1> first = Eigen::Matrix<double, N, 1>::Zero();
  Eigen::Matrix<double, N, N> second = Eigen::Matrix<double, N, N>::Zero();

  static Jet constant(double value) { return {value}; }
  static Jet variable(double value, int place) {
    Jet jet{value};
    jet.first[place] = 1;
    return jet;
  }
};

/// f(x) from f, f' and f'' at x's value.
template <int N>
Jet<N> chained(const Jet<N>& x, double f, double slope, double bend) {
  return {f, slope * x.first, slope * x.second + bend * x.first * x.first.transpose()};
}

template <int N>
Jet<N> operator+(const Jet<N>& a, const Jet<N>& b) {
  return {a.value + b.value, a.first + b.first, a.second + b.second};
}
template <int N>
Jet<N> operator-(const Jet<N>& a, const Jet<N>& b) {
  return {a.value - b.value, a.first - b.first, a.second - b.second};
}
template <int N>
Jet<N> operator*(double factor, const Jet<N>& a) {
  return {factor * a.value, factor * a.first, factor * a.second};
}
template <int N>
Jet<N> operator*(const Jet<N>& a, const Jet<N>& b) {
  const Eigen::Matrix<double, N, N> cross = a.first * b.first.transpose();
  return {a.value * b.value, a.value * b.first + b.value * a.first,
          a.value * b.second + b.value * a.second + cross + cross.transpose()};
}
template <int N>
Jet<N> exp(const Jet<N>& x) {
  const double f = std::exp(x.value);
  return chained(x, f, f, f);
}
template <int N>
Jet<N> log(const Jet<N>& x) {
  const double inverse = 1 / x.value;
  return chained(x, std::log(x.value), inverse, -inverse * inverse);
}

/// ln(exp a + exp b), of whatever size they are.
template <int N>
Jet<N> log_sum(const Jet<N>& a, const Jet<N>& b) {
  const Jet<N> difference = b - a;
  const double x = difference.value;
  const double share = x > 0 ? 1 / (1 + std::exp(-x)) : std::exp(x) / (1 + std::exp(x));
  const double value = x > 0 ? x + std::log1p(std::exp(-x)) : std::log1p(std::exp(x));
  return a + chained(difference, value, share, share * (1 - share));
}

}  // namespace carillon::eval::damping
