#include "eval/classification/calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <limits>

#include "core/error.hpp"

namespace carillon::eval {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
/// Temperatures sought, over the logits' mean range.
constexpr double kLeast = 1e-3;
constexpr double kGreatest = 1e3;

void check_distributions(const ScoreRows& probabilities, std::span<const std::size_t> truth) {
  check_rows(probabilities, "probabilities");
  check_classes(truth, probabilities.samples(), probabilities.columns);
  for (std::size_t i = 0; i < probabilities.samples(); ++i) {
    double sum = 0, least = 0;
    for (const double p : probabilities.row(i)) {
      sum += p;
      least = std::min(least, p);
    }
    // As single precision leaves them.
    if (least < 0 || std::abs(sum - 1) > 1e-4) {
      throw core::InputError(
          fmt::format("probabilities: row {} sums to {} with a least value of {}", i, sum, least),
          "logits become probabilities by softmax");
    }
  }
}

/// -log softmax(beta z)[truth] of one row.
double surprise(std::span<const double> row, std::size_t truth, double beta) {
  const double greatest = *std::max_element(row.begin(), row.end());
  double sum = 0;
  for (const double z : row) sum += std::exp(beta * (z - greatest));
  return std::log(sum) - beta * (row[truth] - greatest);
}

/// Derivative of the sum of surprises by beta: sum of E_p[z] - z_true; rises with beta.
double slope(const ScoreRows& logits, std::span<const std::size_t> truth, double beta) {
  double total = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const auto row = logits.row(i);
    const double greatest = *std::max_element(row.begin(), row.end());
    double sum = 0, mean = 0;
    for (const double z : row) {
      const double weight = std::exp(beta * (z - greatest));
      sum += weight;
      mean += weight * (z - row[truth[i]]);
    }
    total += mean / sum;
  }
  return total;
}

double mean_range(const ScoreRows& logits) {
  double sum = 0;
  for (std::size_t i = 0; i < logits.samples(); ++i) {
    const auto row = logits.row(i);
    const auto [least, greatest] = std::minmax_element(row.begin(), row.end());
    sum += *greatest - *least;
  }
  return sum / static_cast<double>(logits.samples());
}

}  // namespace

double negative_log_likelihood(const ScoreRows& logits, std::span<const std::size_t> truth,
                               double temperature) {
  check_rows(logits, "logits");
  check_classes(truth, logits.samples(), logits.columns);
  check_temperature(temperature);
  double sum = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    sum += surprise(logits.row(i), truth[i], 1 / temperature);
  }
  return truth.empty() ? nan : sum / static_cast<double>(truth.size());
}

FittedTemperature fit_temperature(const ScoreRows& logits, std::span<const std::size_t> truth) {
  FittedTemperature fitted;
  fitted.before = fitted.after = negative_log_likelihood(logits, truth);
  if (truth.empty()) {
    throw core::InputError("a temperature is fitted to samples, and there are none",
                           "give logits of a validation split");
  }
  const double range = mean_range(logits);
  if (range == 0) {
    fitted.at_end = true;
    return fitted;
  }
  const auto slope_at = [&](double log_beta) { return slope(logits, truth, std::exp(log_beta)); };
  const double low = -std::log(kGreatest * range), high = -std::log(kLeast * range);
  double log_beta = 0;
  if (slope_at(low) >= 0) {
    log_beta = low;
    fitted.at_end = true;
  } else if (slope_at(high) <= 0) {
    log_beta = high;
    fitted.at_end = true;
  } else {
    std::uintmax_t steps = 200;
    const auto bracket = boost::math::tools::toms748_solve(
        slope_at, low, high, boost::math::tools::eps_tolerance<double>(48), steps);
    log_beta = 0.5 * (bracket.first + bracket.second);
  }
  fitted.value = std::exp(-log_beta);
  fitted.after = negative_log_likelihood(logits, truth, fitted.value);
  return fitted;
}

std::vector<ReliabilityBin> reliability(const ScoreRows& probabilities,
                                        std::span<const std::size_t> truth, std::size_t bins) {
  if (bins == 0) throw core::InputError("a reliability diagram of no bins");
  check_distributions(probabilities, truth);
  const auto count = static_cast<double>(bins);
  std::vector<ReliabilityBin> diagram(bins);
  for (std::size_t b = 0; b < bins; ++b) {
    diagram[b].low = static_cast<double>(b) / count;
    diagram[b].high = static_cast<double>(b + 1) / count;
  }
  const std::vector<std::size_t> predicted = predicted_classes(probabilities);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const double confidence = probabilities.row(i)[predicted[i]];
    const auto bin =
        std::lower_bound(diagram.begin(), diagram.end() - 1, confidence,
                         [](const ReliabilityBin& one, double value) { return one.high < value; });
    ++bin->samples;
    bin->confidence += confidence;
    bin->accuracy += predicted[i] == truth[i] ? 1 : 0;
  }
  for (ReliabilityBin& bin : diagram) {
    bin.confidence = bin.samples == 0 ? nan : bin.confidence / static_cast<double>(bin.samples);
    bin.accuracy = bin.samples == 0 ? nan : bin.accuracy / static_cast<double>(bin.samples);
  }
  return diagram;
}

double expected_calibration_error(std::span<const ReliabilityBin> bins) {
  double sum = 0, samples = 0;
  for (const ReliabilityBin& bin : bins) {
    if (bin.samples == 0) continue;
    const auto weight = static_cast<double>(bin.samples);
    sum += weight * std::abs(bin.accuracy - bin.confidence);
    samples += weight;
  }
  return samples == 0 ? nan : sum / samples;
}

double brier_score(const ScoreRows& probabilities, std::span<const std::size_t> truth) {
  check_distributions(probabilities, truth);
  double sum = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const auto row = probabilities.row(i);
    for (std::size_t c = 0; c < row.size(); ++c) {
      const double difference = row[c] - (c == truth[i] ? 1 : 0);
      sum += difference * difference;
    }
  }
  return truth.empty() ? nan : sum / static_cast<double>(truth.size());
}

}  // namespace carillon::eval
