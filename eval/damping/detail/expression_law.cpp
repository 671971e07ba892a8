#include "eval/damping/detail/expression_law.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "core/random.hpp"
#include "eval/damping/detail/linear_law.hpp"
#include "synth/damping/damping_expression.hpp"
#include "synth/damping/damping_text.hpp"

namespace carillon::eval::damping {

namespace {

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd values_of(const std::string& expression, const VectorXd& alphas,
                   const std::vector<double>& lambda) {
  const auto c = synth::damping::compile_expression(
      expression, std::vector<double>(alphas.begin(), alphas.end()));
  VectorXd values(static_cast<Index>(lambda.size()));
  for (std::size_t i = 0; i < lambda.size(); ++i) values[Index(i)] = c(lambda[i]);
  return values;
}

/// Alphas of any size: they may be factors as small as 1e-15 or exponents near one.
VectorXd any_alphas(Index n, core::RandomStream& random) {
  VectorXd alphas(n);
  for (double& alpha : alphas) {
    const bool exponent = random.uniform() < 0.5;
    if (exponent) {
      alpha = random.uniform(-2, 2);
    } else {
      // One after the other: arguments are evaluated in an order of the compiler's.
      const double sign = random.uniform() - 0.25;
      alpha = std::copysign(random.log_uniform(1e-9, 1e4), sign);
    }
  }
  return alphas;
}

/// Up to 16 of the eigenvalues, spread.
std::vector<double> some_of(std::vector<double> lambda) {
  std::sort(lambda.begin(), lambda.end());
  constexpr std::size_t maximum = 16;
  if (lambda.size() <= maximum) return lambda;
  std::vector<double> some;
  for (std::size_t i = 0; i < maximum; ++i)
    some.push_back(lambda[i * (lambda.size() - 1) / (maximum - 1)]);
  return some;
}

/// Whether second differences in these alphas vanish wherever tried.
bool is_linear_in(const std::vector<Index>& which, const std::string& expression, Index n,
                  const std::vector<double>& lambda) {
  core::RandomStream random(0, static_cast<std::uint64_t>(which.back()), "fit.linear");
  for (int trial = 0; trial < 40; ++trial) {
    const VectorXd at = any_alphas(n, random);
    const VectorXd other = any_alphas(n, random);
    VectorXd up = at, down = at;
    for (const Index k : which) {
      up[k] += other[k];
      down[k] -= other[k];
    }
    const VectorXd middle = values_of(expression, at, lambda);
    const VectorXd high = values_of(expression, up, lambda);
    const VectorXd low = values_of(expression, down, lambda);
    for (Index i = 0; i < middle.size(); ++i) {
      const double size = std::abs(high[i]) + std::abs(low[i]) + 2 * std::abs(middle[i]);
      if (!std::isfinite(size)) continue;  // says nothing
      // What a small alpha adds to a large one is rounded, not bent.
      if (std::abs(high[i] + low[i] - 2 * middle[i]) > 1e-12 * size) return false;
    }
  }
  return true;
}

std::vector<Index> linear_alphas(const std::string& expression, Index n,
                                 const std::vector<double>& lambda) {
  std::vector<Index> linear;
  for (Index k = 0; k < n; ++k) {
    std::vector<Index> more = linear;
    more.push_back(k);
    if (is_linear_in(more, expression, n, lambda)) linear = more;
  }
  return linear;
}

ScaledLaw linear_expression(const std::string& expression, Index n, const DampingData& data,
                            double scale, std::optional<std::size_t> along) {
  const VectorXd offset = values_of(expression, VectorXd::Zero(n), data.eigenvalues);
  MatrixXd columns(offset.size(), n);
  VectorXd units = VectorXd::Ones(n);
  for (Index k = 0; k < n; ++k) {
    // First to see its size, then with an alpha that neither drowns nor is drowned by the offset.
    for (int pass = 0; pass < 2; ++pass) {
      const VectorXd alphas = units[k] * VectorXd::Unit(n, k);
      columns.col(k) = (values_of(expression, alphas, data.eigenvalues) - offset) / scale;
      const double size = columns.col(k).cwiseAbs().maxCoeff();
      if (pass == 0 && size > 0) units[k] /= size;
    }
  }
  if (!offset.allFinite() || !columns.allFinite()) {
    throw InputError(
        fmt::format("damping \"{}\" is not finite at the features' frequencies", expression));
  }
  return linear_law(columns, offset / scale, units, along);
}

}  // namespace

std::size_t count_alphas(const std::string& expression) {
  std::set<int> numbers;
  for (std::size_t at = 0; at < expression.size();) {
    const auto is_word = [&](std::size_t i) {
      return std::isalnum(static_cast<unsigned char>(expression[i])) != 0 || expression[i] == '_';
    };
    std::size_t end = at;
    while (end < expression.size() && is_word(end)) ++end;
    if (const auto number = synth::damping::alpha_number(expression.substr(at, end - at))) {
      numbers.insert(*number);
    }
    at = std::max(end, at + 1);
  }
  const int last = numbers.empty() ? 0 : *numbers.rbegin();
  for (int number = 1; number < last; ++number) {
    if (numbers.contains(number)) continue;
    throw InputError(
        fmt::format("damping \"{}\" has alpha{}, but no alpha{}", expression, last, number),
        "number the alphas from 1, without gaps");
  }
  // Words that are neither names nor alphas are refused here.
  synth::damping::compile_expression(expression,
                                     std::vector<double>(static_cast<std::size_t>(last), 1.0));
  if (last == 0) {
    throw InputError(fmt::format("damping \"{}\" has no number that could be fitted", expression),
                     "write alpha1, alpha2, ... where numbers are sought");
  }
  return static_cast<std::size_t>(last);
}

ScaledLaw expression_law(const std::string& expression, const DampingData& data, double scale,
                         std::optional<std::size_t> along, const std::vector<double>& near) {
  const auto n = static_cast<Index>(count_alphas(expression));
  const std::vector<Index> linear = linear_alphas(expression, n, some_of(data.eigenvalues));
  if (static_cast<Index>(linear.size()) == n) {
    return linear_expression(expression, n, data, scale, along);
  }
  VectorXd units = VectorXd::Ones(n);
  for (std::size_t k = 0; k < near.size(); ++k) {
    if (near[k] != 0) units[Index(k)] = std::abs(near[k]);
  }
  ScaledLaw law;
  law.box = {VectorXd::Constant(n, -core::infinity), VectorXd::Constant(n, core::infinity)};
  law.curve = [=, lambda = data.eigenvalues](const VectorXd& x) {
    const auto c = [&](const VectorXd& at) {
      return VectorXd(values_of(expression, at.cwiseProduct(units), lambda) / scale);
    };
    Curve curve{c(x), MatrixXd(static_cast<Index>(lambda.size()), n)};
    for (Index k = 0; k < n; ++k) {
      const double step = 1e-5 * std::max(std::abs(x[k]), 1e-3);
      VectorXd up = x, down = x;
      up[k] += step;
      down[k] -= step;
      curve.slopes.col(k) = (c(up) - c(down)) / (up[k] - down[k]);
    }
    return curve;
  };
  law.linear = linear;
  law.alphas = [=](const VectorXd& x) {
    const VectorXd alphas = x.cwiseProduct(units);
    return std::vector<double>(alphas.begin(), alphas.end());
  };
  law.parameters = [=](const std::vector<double>& alphas) {
    return VectorXd(Eigen::Map<const VectorXd>(alphas.data(), n).cwiseQuotient(units));
  };
  if (!near.empty()) {
    const VectorXd middle = law.parameters(near);
    law.candidates = {middle};
    for (Index k = 0; k < n; ++k) {
      if (std::find(linear.begin(), linear.end(), k) != linear.end()) continue;
      for (const double factor : {0.5, 0.8, 0.9, 0.95, 1.05, 1.1, 1.25, 2.0}) {
        law.candidates.push_back(middle);
        law.candidates.back()[k] *= factor;
      }
    }
    return law;
  }
  core::RandomStream random(0, 0, "fit.candidates");
  for (int candidate = 0; candidate < 300; ++candidate) {
    VectorXd x = any_alphas(n, random);
    for (const Index k : linear) x[k] = 0;
    law.candidates.push_back(x);
  }
  return law;
}

}  // namespace carillon::eval::damping
