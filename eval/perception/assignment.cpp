#include "eval/perception/assignment.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/error.hpp"
#include "core/numbers.hpp"

namespace carillon::eval::perception {

namespace {

/// Column of each row for the least sum of -gains; rows <= columns, every row gets one.
std::vector<std::size_t> assign(const std::vector<double>& gains, std::size_t rows,
                                std::size_t columns) {
  std::vector<double> of_row(rows, 0.0), of_column(columns, 0.0);  // dual variables
  std::vector<std::size_t> row_of(columns, unpaired), column_of(rows, unpaired);
  for (std::size_t start = 0; start < rows; ++start) {
    std::vector<double> distance(columns, core::infinity);
    std::vector<std::size_t> before(columns, unpaired);
    std::vector<bool> reached(columns, false);
    std::size_t row = start, last = unpaired;
    double way = 0;
    // Dijkstra over reduced costs, until a free column is the nearest.
    while (true) {
      std::size_t nearest = unpaired;
      for (std::size_t c = 0; c < columns; ++c) {
        if (reached[c]) continue;
        const double to = way - gains[row * columns + c] - of_row[row] - of_column[c];
        if (to < distance[c]) {
          distance[c] = to;
          before[c] = last;
        }
        if (nearest == unpaired || distance[c] < distance[nearest]) nearest = c;
      }
      reached[nearest] = true;
      way = distance[nearest];
      last = nearest;
      if (row_of[nearest] == unpaired) break;
      row = row_of[nearest];
    }
    of_row[start] += way;
    for (std::size_t c = 0; c < columns; ++c) {
      if (!reached[c] || c == last) continue;
      of_column[c] += distance[c] - way;
      of_row[row_of[c]] += way - distance[c];
    }
    for (std::size_t c = last; c != unpaired; c = before[c]) {
      row_of[c] = before[c] == unpaired ? start : row_of[before[c]];
      column_of[row_of[c]] = c;
    }
  }
  return column_of;
}

}  // namespace

std::vector<std::size_t> best_pairs(std::span<const double> gains, std::size_t rows,
                                    std::size_t columns) {
  if (gains.size() != rows * columns) {
    throw core::InputError(
        fmt::format("{} gains do not fill {} rows of {}", gains.size(), rows, columns));
  }
  for (const double gain : gains) {
    if (!(gain >= 0) || !std::isfinite(gain)) {
      throw core::InputError(fmt::format("a pair cannot gain {}", gain));
    }
  }
  const bool turned = rows > columns;
  std::vector<double> table(gains.size());
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t c = 0; c < columns; ++c) {
      table[turned ? c * rows + r : r * columns + c] = gains[r * columns + c];
    }
  }
  const auto partners = turned ? assign(table, columns, rows) : assign(table, rows, columns);
  std::vector<std::size_t> column_of(rows, unpaired);
  for (std::size_t i = 0; i < partners.size(); ++i) {
    const std::size_t r = turned ? partners[i] : i, c = turned ? i : partners[i];
    if (gains[r * columns + c] > 0) column_of[r] = c;
  }
  return column_of;
}

}  // namespace carillon::eval::perception
