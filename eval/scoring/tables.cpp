#include "eval/scoring/tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace carillon::eval::scoring {

std::string figure(double number, int digits) {
  return !std::isfinite(number) ? "-" : fmt::format("{:.{}f}", number, digits);
}

std::string percent(double fraction) {
  return figure(100 * fraction, 2);
}

std::string with_interval(const std::optional<Estimate>& estimate) {
  if (!estimate) return "-";
  return fmt::format("{} [{}, {}]", percent(estimate->mean), percent(estimate->interval95.low),
                     percent(estimate->interval95.high));
}

std::string markdown(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths(rows.front().size(), 3);
  for (const auto& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  }
  std::string text;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (std::size_t c = 0; c < rows[r].size(); ++c) {
      text += fmt::format("| {:{}} ", rows[r][c], widths[c]);
    }
    text += "|\n";
    if (r > 0) continue;
    for (const std::size_t width : widths) text += fmt::format("| {} ", std::string(width, '-'));
    text += "|\n";
  }
  return text;
}

}  // namespace carillon::eval::scoring
