#include "eval/classification/confusion.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "eval/classification/score_rows.hpp"

namespace carillon::eval::classification {

namespace {

using core::nan;

double fraction(std::size_t part, std::size_t whole) {
  return whole == 0 ? nan : static_cast<double>(part) / static_cast<double>(whole);
}

std::size_t row_sum(const Confusion& confusion, std::size_t row) {
  std::size_t sum = 0;
  for (std::size_t c = 0; c < confusion.classes; ++c) sum += confusion.at(row, c);
  return sum;
}

}  // namespace

Confusion count_confusion(std::span<const std::size_t> truth,
                          std::span<const std::size_t> predicted, std::size_t classes) {
  if (classes == 0) throw core::InputError("a confusion matrix of no classes");
  check_classes(truth, predicted.size(), classes);
  check_classes(predicted, truth.size(), classes);
  Confusion confusion{classes, std::vector<std::size_t>(classes * classes, 0)};
  for (std::size_t i = 0; i < truth.size(); ++i) {
    ++confusion.counts[truth[i] * classes + predicted[i]];
  }
  return confusion;
}

void add(Confusion& total, const Confusion& more) {
  for (std::size_t i = 0; i < total.counts.size(); ++i) total.counts[i] += more.counts.at(i);
}

double accuracy(const Confusion& confusion) {
  std::size_t right = 0, all = 0;
  for (std::size_t c = 0; c < confusion.classes; ++c) {
    right += confusion.at(c, c);
    all += row_sum(confusion, c);
  }
  return fraction(right, all);
}

std::vector<double> recalls(const Confusion& confusion) {
  std::vector<double> values;
  for (std::size_t c = 0; c < confusion.classes; ++c) {
    values.push_back(fraction(confusion.at(c, c), row_sum(confusion, c)));
  }
  return values;
}

double balanced_accuracy(const Confusion& confusion) {
  double sum = 0;
  std::size_t occurring = 0;
  for (const double recall : recalls(confusion)) {
    if (std::isnan(recall)) continue;
    sum += recall;
    ++occurring;
  }
  return occurring == 0 ? nan : sum / static_cast<double>(occurring);
}

std::vector<double> row_fractions(const Confusion& confusion) {
  std::vector<double> fractions;
  for (std::size_t r = 0; r < confusion.classes; ++r) {
    const std::size_t samples = row_sum(confusion, r);
    for (std::size_t c = 0; c < confusion.classes; ++c) {
      fractions.push_back(fraction(confusion.at(r, c), samples));
    }
  }
  return fractions;
}

ConfusionDifference confusion_difference(const Confusion& a, const Confusion& b) {
  if (a.classes != b.classes) {
    throw core::InputError(fmt::format(
        "confusion matrices of {} and of {} classes cannot be compared", a.classes, b.classes));
  }
  const std::vector<double> first = row_fractions(a), second = row_fractions(b);
  ConfusionDifference difference;
  double squares = 0;
  for (std::size_t r = 0; r < a.classes; ++r) {
    double row = 0;
    for (std::size_t i = r * a.classes; i < (r + 1) * a.classes; ++i) {
      row += (first[i] - second[i]) * (first[i] - second[i]);
    }
    if (std::isnan(row)) continue;
    squares += row;
    ++difference.rows;
  }
  difference.norm = difference.rows == 0 ? nan : std::sqrt(squares);
  return difference;
}

}  // namespace carillon::eval::classification
