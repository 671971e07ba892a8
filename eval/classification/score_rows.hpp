#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace carillon::eval::classification {

/// Numbers of samples, a row each: logits or probabilities of classes, or features of a network's
/// last layer but one. Seen, not held.
struct ScoreRows {
  std::span<const double> values;  ///< samples x columns, row after row
  std::size_t columns = 0;

  std::size_t samples() const { return columns == 0 ? 0 : values.size() / columns; }
  std::span<const double> row(std::size_t i) const { return values.subspan(i * columns, columns); }
};

/// @param name  of the rows in messages, e.g. "logits"
/// @throws InputError  no columns, values that do not fill whole rows, or one that is not finite
///                     (names row and column, from 0)
void check_rows(const ScoreRows& rows, const std::string& name);

/// @throws InputError  not one class for each of `samples`, or one that is not below `classes`
///                     (names the sample)
void check_classes(std::span<const std::size_t> truth, std::size_t samples, std::size_t classes);

/// @throws InputError  not positive and finite
void check_temperature(double temperature);

/// log sum exp of a row that is not empty, without overflow.
double log_sum_exp(std::span<const double> row);

/// Probabilities softmax(z / T) of every row, samples x columns values.
/// @param temperature  T > 0
/// @throws InputError  as check_rows, or a temperature that is not positive
std::vector<double> softmax(const ScoreRows& logits, double temperature = 1);

/// The column of the greatest value of each row; of equal ones the first.
/// @throws InputError  as check_rows
std::vector<std::size_t> predicted_classes(const ScoreRows& scores);

}  // namespace carillon::eval::classification
