#include "eval/classification/score_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace carillon::eval::classification {

void check_rows(const ScoreRows& rows, const std::string& name) {
  if (rows.columns == 0) throw core::InputError(fmt::format("{} without columns", name));
  if (rows.values.size() % rows.columns != 0) {
    throw core::InputError(
        fmt::format("{} {} do not fill rows of {}", rows.values.size(), name, rows.columns));
  }
  for (std::size_t i = 0; i < rows.values.size(); ++i) {
    if (!std::isfinite(rows.values[i])) {
      throw core::InputError(fmt::format("{}: row {}, column {} is {}", name, i / rows.columns,
                                         i % rows.columns, rows.values[i]),
                             "a network that gives such values has not been trained; rows and "
                             "columns count from 0");
    }
  }
}

void check_classes(std::span<const std::size_t> truth, std::size_t samples, std::size_t classes) {
  if (truth.size() != samples) {
    throw core::InputError(fmt::format("{} classes of {} samples", truth.size(), samples));
  }
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (truth[i] >= classes) {
      throw core::InputError(
          fmt::format("sample {} is of class {}, of {} classes", i, truth[i], classes),
          "samples and classes count from 0");
    }
  }
}

void check_temperature(double temperature) {
  if (!(temperature > 0) || !std::isfinite(temperature)) {
    throw core::InputError(fmt::format("a temperature of {} is not positive", temperature));
  }
}

double log_sum_exp(std::span<const double> row) {
  const double greatest = *std::max_element(row.begin(), row.end());
  double sum = 0;
  for (const double value : row) sum += std::exp(value - greatest);
  return greatest + std::log(sum);
}

std::vector<double> softmax(const ScoreRows& logits, double temperature) {
  check_rows(logits, "logits");
  check_temperature(temperature);
  std::vector<double> fractions;
  fractions.reserve(logits.values.size());
  for (std::size_t i = 0; i < logits.samples(); ++i) {
    const auto row = logits.row(i);
    const double greatest = *std::max_element(row.begin(), row.end());
    double sum = 0;
    for (const double z : row) {
      fractions.push_back(std::exp((z - greatest) / temperature));
      sum += fractions.back();
    }
    for (std::size_t c = 0; c < logits.columns; ++c) fractions[i * logits.columns + c] /= sum;
  }
  return fractions;
}

std::vector<std::size_t> predicted_classes(const ScoreRows& scores) {
  check_rows(scores, "scores");
  std::vector<std::size_t> classes;
  for (std::size_t i = 0; i < scores.samples(); ++i) {
    const auto row = scores.row(i);
    classes.push_back(
        static_cast<std::size_t>(std::max_element(row.begin(), row.end()) - row.begin()));
  }
  return classes;
}

}  // namespace carillon::eval::classification
