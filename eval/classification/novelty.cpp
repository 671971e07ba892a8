#include "eval/classification/novelty.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"

namespace carillon::eval {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
/// Less would leave directions in which the samples do not vary without an inverse.
constexpr double kLeastShrinkage = 1e-6;
/// Of a mean square: what is left of equal features when their mean is taken off.
constexpr double kRounding = 1e-24;

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Eigen::Map<const RowMatrix> as_matrix(const ScoreRows& rows) {
  return {rows.values.data(), static_cast<Eigen::Index>(rows.samples()),
          static_cast<Eigen::Index>(rows.columns)};
}

std::vector<double> sorted_scores(std::span<const double> scores, const char* name) {
  for (std::size_t i = 0; i < scores.size(); ++i) {
    if (std::isnan(scores[i])) {
      throw core::InputError(fmt::format("{} score {} is no number", name, i));
    }
  }
  std::vector<double> sorted(scores.begin(), scores.end());
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

/// Ledoit and Wolf 2004, section 3.3: the share whose expected squared error is least, of rows x
/// that have their classes' means taken off.
double ledoit_wolf(const RowMatrix& x, const Eigen::MatrixXd& covariance) {
  const auto samples = static_cast<double>(x.rows());
  const double middle = covariance.diagonal().mean();
  const double off =
      covariance.squaredNorm() - middle * middle * static_cast<double>(covariance.rows());
  if (!(off > 0)) return 1;
  const double fourth = x.rowwise().squaredNorm().squaredNorm();
  const double noise = (fourth / samples - covariance.squaredNorm()) / samples;
  return std::clamp(noise / off, 0.0, 1.0);
}

}  // namespace

double auroc(std::span<const double> known, std::span<const double> novel) {
  const std::vector<double> positive = sorted_scores(known, "known");
  const std::vector<double> negative = sorted_scores(novel, "novel");
  if (positive.empty() || negative.empty()) return nan;
  double below = 0;
  auto less = negative.begin(), equal = negative.begin();
  for (const double score : positive) {
    while (less != negative.end() && *less < score) ++less;
    while (equal != negative.end() && *equal <= score) ++equal;
    below += 0.5 * static_cast<double>((less - negative.begin()) + (equal - negative.begin()));
  }
  return below / (static_cast<double>(positive.size()) * static_cast<double>(negative.size()));
}

double threshold_at(std::span<const double> known, double rate) {
  if (!(rate > 0 && rate <= 1)) {
    throw core::InputError(fmt::format("a true-positive rate of {}", rate), "0.95, for instance");
  }
  const std::vector<double> sorted = sorted_scores(known, "known");
  if (sorted.empty()) throw core::InputError("a threshold for no known samples");
  // A rate that is k / n but for rounding asks for k.
  const auto count = static_cast<double>(sorted.size());
  const auto wanted =
      static_cast<std::size_t>(std::clamp(std::ceil(rate * count - 1e-9 * count), 1.0, count));
  return sorted[sorted.size() - wanted];
}

double share_reaching(std::span<const double> scores, double threshold) {
  const std::vector<double> sorted = sorted_scores(scores, "novel");
  if (sorted.empty()) return nan;
  const auto first = std::lower_bound(sorted.begin(), sorted.end(), threshold);
  return static_cast<double>(sorted.end() - first) / static_cast<double>(sorted.size());
}

std::vector<double> energy_scores(const ScoreRows& logits, double temperature) {
  check_rows(logits, "logits");
  check_temperature(temperature);
  std::vector<double> scores, row;
  for (std::size_t i = 0; i < logits.samples(); ++i) {
    row.assign(logits.row(i).begin(), logits.row(i).end());
    for (double& z : row) z /= temperature;
    scores.push_back(temperature * log_sum_exp(row));
  }
  return scores;
}

std::vector<double> softmax_scores(const ScoreRows& logits, double temperature) {
  const std::vector<double> probabilities = softmax(logits, temperature);
  std::vector<double> scores;
  for (std::size_t i = 0; i < logits.samples(); ++i) {
    const auto begin = probabilities.begin() + static_cast<std::ptrdiff_t>(i * logits.columns);
    scores.push_back(*std::max_element(begin, begin + static_cast<std::ptrdiff_t>(logits.columns)));
  }
  return scores;
}

FeatureGaussians fit_gaussians(const ScoreRows& features, std::span<const std::size_t> truth,
                               std::size_t classes, std::optional<double> shrinkage) {
  check_rows(features, "features");
  check_classes(truth, features.samples(), classes);
  if (truth.empty()) throw core::InputError("Gaussians are fitted to samples, and there are none");
  if (shrinkage && !(*shrinkage >= 0 && *shrinkage <= 1)) {
    throw core::InputError(fmt::format("a shrinkage of {}", *shrinkage), "from 0 to 1");
  }
  RowMatrix x = as_matrix(features);
  const double square = x.squaredNorm() / static_cast<double>(x.size());
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(x.cols(), static_cast<Eigen::Index>(classes));
  Eigen::VectorXd counts = Eigen::VectorXd::Zero(sums.cols());
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const auto c = static_cast<Eigen::Index>(truth[static_cast<std::size_t>(i)]);
    sums.col(c) += x.row(i).transpose();
    counts(c) += 1;
  }
  const Eigen::MatrixXd means = sums * counts.cwiseMax(1).cwiseInverse().asDiagonal();
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    x.row(i) -=
        means.col(static_cast<Eigen::Index>(truth[static_cast<std::size_t>(i)])).transpose();
  }
  Eigen::MatrixXd covariance = x.transpose() * x / static_cast<double>(x.rows());
  const double middle = covariance.diagonal().mean();
  if (!(middle > kRounding * square)) {
    throw core::InputError("the features do not vary within any class, so distances have no unit",
                           "give several samples of at least one class");
  }
  FeatureGaussians gaussians;
  gaussians.shrinkage = std::max(kLeastShrinkage, shrinkage.value_or(ledoit_wolf(x, covariance)));
  covariance *= 1 - gaussians.shrinkage;
  covariance.diagonal().array() += gaussians.shrinkage * middle;
  gaussians.cholesky = covariance.llt().matrixL();
  std::vector<Eigen::Index> occurring;
  for (Eigen::Index c = 0; c < counts.size(); ++c) {
    if (counts(c) > 0) occurring.push_back(c);
  }
  gaussians.centres = gaussians.cholesky.triangularView<Eigen::Lower>().solve(
      Eigen::MatrixXd(means(Eigen::all, occurring)));
  return gaussians;
}

std::vector<double> mahalanobis_scores(const FeatureGaussians& gaussians,
                                       const ScoreRows& features) {
  check_rows(features, "features");
  if (static_cast<Eigen::Index>(features.columns) != gaussians.cholesky.rows()) {
    throw core::InputError(fmt::format("{} features of a sample, where {} were fitted",
                                       features.columns, gaussians.cholesky.rows()));
  }
  const Eigen::MatrixXd white =
      gaussians.cholesky.triangularView<Eigen::Lower>().solve(as_matrix(features).transpose());
  std::vector<double> scores;
  for (Eigen::Index i = 0; i < white.cols(); ++i) {
    scores.push_back(
        -(gaussians.centres.colwise() - white.col(i)).colwise().squaredNorm().minCoeff());
  }
  return scores;
}

}  // namespace carillon::eval
