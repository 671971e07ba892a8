#include "eval/damping/detail/linear_law.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.hpp"
#include "core/numbers.hpp"

namespace carillon::eval::damping {

namespace {

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Columns of length one, in an order of their own.
MatrixXd normalised(const MatrixXd& columns, const VectorXd& norms,
                    const std::vector<Index>& order) {
  MatrixXd ordered(columns.rows(), columns.cols());
  for (Index k = 0; k < columns.cols(); ++k) {
    const Index from = order[std::size_t(k)];
    if (!(norms[from] > 0) || !std::isfinite(norms[from])) {
      throw InputError(fmt::format("{} has no bearing on damping at these frequencies",
                                   synth::damping::parameter_name(std::size_t(from))),
                       "leave it out");
    }
    ordered.col(k) = columns.col(from) / norms[from];
  }
  return ordered;
}

}  // namespace

ScaledLaw linear_law(const MatrixXd& columns, const VectorXd& offset, const VectorXd& units,
                     std::optional<std::size_t> along) {
  const Index n = columns.cols();
  // The last column of the triangle belongs to one alpha alone: the one to be held goes there, but
  // its parameter keeps its place.
  std::vector<Index> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  if (along) {
    const auto held = order.begin() + static_cast<std::ptrdiff_t>(*along);
    std::rotate(held, held + 1, order.end());
  }
  const VectorXd norms = columns.colwise().norm();
  const Eigen::HouseholderQR<MatrixXd> factor(normalised(columns, norms, order));
  const Index ranks = std::min(n, columns.rows());
  if (ranks < n || factor.matrixQR().diagonal().cwiseAbs().minCoeff() < 1e-11) {
    throw InputError(
        fmt::format("{} parameters cannot be told apart at the features' frequencies", n),
        "give more features, or fit fewer parameters");
  }
  const MatrixXd triangle = factor.matrixQR().topRows(n).triangularView<Eigen::Upper>();
  const double root = std::sqrt(static_cast<double>(columns.rows()));
  MatrixXd basis(columns.rows(), n);
  basis(Eigen::all, order) = root * (factor.householderQ() * MatrixXd::Identity(columns.rows(), n));

  ScaledLaw law;
  law.box = {VectorXd::Constant(n, -core::infinity), VectorXd::Constant(n, core::infinity)};
  law.curve = [=](const VectorXd& x) { return Curve{basis * x + offset, basis}; };
  law.linear.resize(std::size_t(n));
  std::iota(law.linear.begin(), law.linear.end(), 0);
  law.candidates = {VectorXd::Zero(n)};
  law.alphas = [=](const VectorXd& x) {
    const VectorXd ordered = triangle.triangularView<Eigen::Upper>().solve(root * x(order));
    VectorXd alphas(n);
    alphas(order) = ordered;
    alphas = alphas.cwiseQuotient(norms).cwiseProduct(units).eval();
    return std::vector<double>(alphas.data(), alphas.data() + n);
  };
  law.parameters = [=](const std::vector<double>& alphas) {
    const VectorXd scaled =
        Eigen::Map<const VectorXd>(alphas.data(), n).cwiseProduct(norms).cwiseQuotient(units);
    VectorXd x(n);
    x(order) = triangle * scaled(order) / root;
    return x;
  };
  return law;
}

}  // namespace carillon::eval::damping
