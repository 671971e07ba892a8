#include "eval/studies/learning/detail/tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace carillon::eval::studies {

using nlohmann::ordered_json;

std::string percent(const ordered_json& fraction) {
  return fraction.is_null() ? "-" : fmt::format("{:.2f}", 100 * fraction.get<double>());
}

/// "93.21 [90.10, 95.80]"
std::string with_interval(const ordered_json& summary) {
  if (summary.is_null()) return "-";
  const ordered_json& bounds = summary.at("interval95");
  return fmt::format("{} [{}, {}]", percent(summary.at("mean")), percent(bounds.at(0)),
                     percent(bounds.at(1)));
}

/// Lines of a Markdown table, columns as wide as their widest cell.
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

}  // namespace carillon::eval::studies
