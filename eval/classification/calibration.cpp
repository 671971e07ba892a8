#include "eval/classification/calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <map>
#include <numeric>

#include "core/error.hpp"
#include "core/numbers.hpp"

namespace carillon::eval::classification {

namespace {

using core::nan;
/// Temperatures sought, over the logits' mean range.
constexpr double min_value = 1e-3;
constexpr double max_value = 1e3;

void check_distributions(const ScoreRows& probabilities, std::span<const std::size_t> truth) {
  check_rows(probabilities, "probabilities");
  check_classes(truth, probabilities.samples(), probabilities.columns);
  for (std::size_t i = 0; i < probabilities.samples(); ++i) {
    double sum = 0, minimum = 0;
    for (const double p : probabilities.row(i)) {
      sum += p;
      minimum = std::min(minimum, p);
    }
    // As single precision leaves them.
    if (minimum < 0 || std::abs(sum - 1) > 1e-4) {
      throw core::InputError(
          fmt::format("probabilities: row {} sums to {} with a least value of {}", i, sum, minimum),
          "logits become probabilities by softmax");
    }
  }
}

/// Derivative by beta of the sum of cross-entropies: sum of E_p[z] - E_target[z]; rises with beta.
double slope(const ScoreRows& logits, std::span<const std::size_t> truth, double beta) {
  const double doubt = 1 / (static_cast<double>(truth.size()) + 2);
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
    const double mean_of_others = (std::accumulate(row.begin(), row.end(), 0.0) - row[truth[i]]) /
                                  (static_cast<double>(row.size()) - 1);
    total += mean / sum - doubt * (mean_of_others - row[truth[i]]);
  }
  return total;
}

double mean_range(const ScoreRows& logits) {
  double sum = 0;
  for (std::size_t i = 0; i < logits.samples(); ++i) {
    const auto row = logits.row(i);
    const auto [minimum, maximum] = std::minmax_element(row.begin(), row.end());
    sum += *maximum - *minimum;
  }
  return sum / static_cast<double>(logits.samples());
}

/// The greatest probability of each row.
std::vector<double> confidences(const ScoreRows& probabilities) {
  std::vector<double> sure;
  for (std::size_t i = 0; i < probabilities.samples(); ++i) {
    const auto row = probabilities.row(i);
    sure.push_back(*std::max_element(row.begin(), row.end()));
  }
  return sure;
}

std::vector<ReliabilityBin> diagram_of(const std::vector<double>& sure,
                                       const std::vector<bool>& right, std::size_t bins) {
  if (bins == 0) throw core::InputError("a reliability diagram of no bins");
  const auto count = static_cast<double>(bins);
  std::vector<ReliabilityBin> diagram(bins);
  for (std::size_t b = 0; b < bins; ++b) {
    diagram[b].low = static_cast<double>(b) / count;
    diagram[b].high = static_cast<double>(b + 1) / count;
  }
  for (std::size_t i = 0; i < sure.size(); ++i) {
    const auto bin =
        std::lower_bound(diagram.begin(), diagram.end() - 1, sure[i],
                         [](const ReliabilityBin& one, double value) { return one.high < value; });
    ++bin->samples;
    bin->confidence += sure[i];
    bin->accuracy += right[i] ? 1 : 0;
  }
  for (ReliabilityBin& bin : diagram) {
    bin.confidence = bin.samples == 0 ? nan : bin.confidence / static_cast<double>(bin.samples);
    bin.accuracy = bin.samples == 0 ? nan : bin.accuracy / static_cast<double>(bin.samples);
  }
  return diagram;
}

}  // namespace

double fit_temperature(const ScoreRows& logits, std::span<const std::size_t> truth) {
  check_rows(logits, "logits");
  check_classes(truth, logits.samples(), logits.columns);
  if (truth.empty()) {
    throw core::InputError("a temperature is fitted to samples, and there are none",
                           "give logits of a validation split");
  }
  const double range = mean_range(logits);
  if (range == 0) return 1;
  const auto slope_at = [&](double log_beta) { return slope(logits, truth, std::exp(log_beta)); };
  const double low = -std::log(max_value * range), high = -std::log(min_value * range);
  if (slope_at(low) >= 0) return std::exp(-low);
  if (slope_at(high) <= 0) return std::exp(-high);
  std::uintmax_t steps = 200;
  const auto bracket = boost::math::tools::toms748_solve(
      slope_at, low, high, boost::math::tools::eps_tolerance<double>(48), steps);
  return std::exp(-0.5 * (bracket.first + bracket.second));
}

std::vector<ReliabilityBin> reliability(const ScoreRows& probabilities,
                                        std::span<const std::size_t> truth, std::size_t bins) {
  check_distributions(probabilities, truth);
  const std::vector<std::size_t> predicted = predicted_classes(probabilities);
  std::vector<bool> right;
  for (std::size_t i = 0; i < truth.size(); ++i) right.push_back(predicted[i] == truth[i]);
  return diagram_of(confidences(probabilities), right, bins);
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

double calibration_error_by_chance(const ScoreRows& probabilities,
                                   std::span<const std::size_t> groups, core::RandomStream& random,
                                   int draws) {
  if (groups.size() != probabilities.samples()) {
    throw core::InputError(
        fmt::format("{} groups of {} samples", groups.size(), probabilities.samples()));
  }
  const std::vector<double> sure = confidences(probabilities);
  std::map<std::size_t, double> luck;
  for (const std::size_t group : groups) luck[group] = 0;
  std::vector<bool> right(sure.size());
  double sum = 0;
  for (int draw = 0; draw < draws; ++draw) {
    for (auto& [group, value] : luck) value = random.uniform();
    for (std::size_t i = 0; i < sure.size(); ++i) right[i] = luck[groups[i]] < sure[i];
    sum += expected_calibration_error(diagram_of(sure, right, usual_bins));
  }
  return sum / draws;
}

}  // namespace carillon::eval::classification
