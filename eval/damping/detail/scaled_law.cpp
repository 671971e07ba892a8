#include "eval/damping/detail/scaled_law.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "eval/damping/detail/expression_law.hpp"
#include "eval/damping/detail/linear_law.hpp"

namespace carillon::eval::damping {

namespace {

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using synth::damping::DampingKind;

using core::infinity;

/// c = alpha1 + alpha2 lambda, neither negative.
ScaledLaw rayleigh(const DampingData& data, double scale) {
  const auto lambda = Eigen::Map<const VectorXd>(data.eigenvalues.data(), Index(data.size()));
  const double middle = lambda.mean();
  MatrixXd basis(lambda.size(), 2);
  basis << VectorXd::Ones(lambda.size()), lambda / middle;
  ScaledLaw law;
  law.box = {VectorXd::Zero(2), VectorXd::Constant(2, infinity)};
  law.curve = [basis](const VectorXd& x) { return Curve{basis * x, basis}; };
  law.linear = {0, 1};
  law.candidates = {VectorXd::Zero(2)};
  law.alphas = [=](const VectorXd& x) {
    return std::vector<double>{x[0] * scale, x[1] * scale / middle};
  };
  law.parameters = [=](const std::vector<double>& alphas) {
    return VectorXd(Eigen::Vector2d(alphas[0] / scale, alphas[1] * middle / scale));
  };
  return law;
}

/// Powers of lambda over its largest, so that none overflows.
ScaledLaw caughey(const DampingData& data, std::size_t terms, double scale,
                  std::optional<std::size_t> along) {
  const auto lambda = Eigen::Map<const VectorXd>(data.eigenvalues.data(), Index(data.size()));
  const double largest = lambda.maxCoeff();
  const auto n = static_cast<Index>(terms);
  MatrixXd columns(lambda.size(), n);
  VectorXd units(n);
  for (Index k = 0; k < n; ++k) {
    columns.col(k) = (lambda / largest).array().pow(static_cast<double>(k));
    units[k] = scale / std::pow(largest, static_cast<double>(k));
  }
  return linear_law(columns, VectorXd::Zero(lambda.size()), units, along);
}

/// c = alpha1 + A (lambda / middle)^p, or without alpha1: linear in A >= 0 unless A's logarithm is
/// asked for.
ScaledLaw power(const DampingData& data, bool constant, double scale,
                std::optional<std::size_t> along) {
  const auto lambda = Eigen::Map<const VectorXd>(data.eigenvalues.data(), Index(data.size()));
  const VectorXd logs = lambda.array().log();
  const Index a = constant ? 1 : 0;  // where A stands; p follows
  const Index size = a + 2;
  const bool as_logarithm = along && static_cast<Index>(*along) == a;
  // A is the alpha itself where it is to be held.
  const double middle = as_logarithm ? 0 : logs.mean();
  const VectorXd from_middle = logs.array() - middle;

  ScaledLaw law;
  law.box = {VectorXd::Zero(size), VectorXd::Constant(size, infinity)};
  law.box.low[a + 1] = -largest_exponent;
  law.box.high[a + 1] = largest_exponent;
  if (as_logarithm) law.box.low[a] = -infinity;
  const auto powers = [=](const VectorXd& x) {
    const double factor = as_logarithm ? x[a] : 0;
    return VectorXd((factor + x[a + 1] * from_middle.array()).exp());
  };
  law.curve = [=](const VectorXd& x) {
    const VectorXd power = powers(x);
    const double factor = as_logarithm ? 1 : x[a];
    Curve curve{factor * power, MatrixXd(power.size(), size)};
    if (constant) {
      curve.values.array() += x[0];
      curve.slopes.col(0).setOnes();
    }
    curve.slopes.col(a) = power;
    curve.slopes.col(a + 1) = factor * power.cwiseProduct(from_middle);
    return curve;
  };
  law.bend = [=](const VectorXd& x, const VectorXd& weights) {
    const VectorXd weighed = weights.cwiseProduct(powers(x));
    const VectorXd once = weighed.cwiseProduct(from_middle);
    MatrixXd bend = MatrixXd::Zero(size, size);
    if (as_logarithm) bend(a, a) = weighed.sum();
    bend(a, a + 1) = bend(a + 1, a) = once.sum();
    bend(a + 1, a + 1) = (as_logarithm ? 1 : x[a]) * once.dot(from_middle);
    return bend;
  };
  for (Index k = 0; k < size - (as_logarithm ? 2 : 1); ++k) law.linear.push_back(k);
  for (int tenth = -10; tenth <= 20; ++tenth) {
    if (constant && tenth == 0) continue;  // two constants
    VectorXd x = VectorXd::Zero(size);
    x[a + 1] = tenth / 10.0;
    law.candidates.push_back(x);
  }
  law.alphas = [=](const VectorXd& x) {
    std::vector<double> alphas(x.data(), x.data() + size);
    if (constant) alphas[0] *= scale;
    const double factor = as_logarithm ? std::exp(x[a]) : x[a];
    alphas[std::size_t(a)] = factor * scale * std::exp(-x[a + 1] * middle);
    return alphas;
  };
  law.parameters = [=](const std::vector<double>& alphas) {
    VectorXd x = Eigen::Map<const VectorXd>(alphas.data(), size);
    if (constant) x[0] /= scale;
    x[a] *= std::exp(x[a + 1] * middle) / scale;
    if (as_logarithm) x[a] = std::log(x[a]);
    return x;
  };
  return law;
}

}  // namespace

std::size_t parameter_count(const DampingLaw& law) {
  switch (law.kind) {
    case DampingKind::caughey:
      if (law.parameters == 0) throw InputError("a Caughey series needs one term or more");
      return law.parameters;
    case DampingKind::expression:
      return count_alphas(law.expression);
    default:
      return synth::damping::form_of(law.kind).min_parameters;
  }
}

ScaledLaw scaled_law(const DampingLaw& law, const DampingData& data,
                     std::optional<std::size_t> along, const std::vector<double>& near) {
  const double scale = core::median(data.coefficients);
  ScaledLaw scaled;
  switch (law.kind) {
    case DampingKind::rayleigh:
      scaled = rayleigh(data, scale);
      break;
    case DampingKind::caughey:
      scaled = caughey(data, parameter_count(law), scale, along);
      break;
    case DampingKind::expression:
      scaled = expression_law(law.expression, data, scale, along, near);
      break;
    default:
      scaled = power(data, law.kind == DampingKind::hybrid, scale, along);
  }
  scaled.scale = scale;
  return scaled;
}

}  // namespace carillon::eval::damping
