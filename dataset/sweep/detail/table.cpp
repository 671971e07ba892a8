#include "dataset/sweep/detail/table.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/csv.hpp"

namespace carillon::dataset::sweep {

using nlohmann::ordered_json;

namespace {

std::string cell(const ordered_json& value) {
  return value.is_number_float() ? core::csv_number(value.get<double>(), 6)
                                 : core::csv_value(value);
}

/// Head and rows of the table, the variant's folder first.
std::vector<std::vector<std::string>> cells(const Sweep& sweep,
                                            const std::vector<ordered_json>& rows) {
  std::vector<std::vector<std::string>> table(1);
  table[0].push_back("variant");
  table[0].insert(table[0].end(), sweep.keys.begin(), sweep.keys.end());
  for (const auto& [name, value] : rows.front().items()) table[0].push_back(name);
  for (std::size_t v = 0; v < rows.size(); ++v) {
    std::vector<std::string> line = {sweep.variants[v].folder};
    line.insert(line.end(), sweep.variants[v].values.begin(), sweep.variants[v].values.end());
    for (const auto& [name, value] : rows[v].items()) line.push_back(cell(value));
    table.push_back(std::move(line));
  }
  return table;
}

}  // namespace

std::string csv_table(const Sweep& sweep, const std::vector<ordered_json>& rows) {
  std::string text;
  for (const auto& line : cells(sweep, rows)) text += core::csv_line(line);
  return text;
}

ordered_json json_table(const std::string& name, const Sweep& sweep,
                        const std::vector<ordered_json>& rows) {
  ordered_json variants = ordered_json::array();
  for (std::size_t v = 0; v < rows.size(); ++v) {
    ordered_json values = ordered_json::object();
    for (std::size_t k = 0; k < sweep.keys.size(); ++k) {
      values[sweep.keys[k]] = sweep.variants[v].values[k];
    }
    ordered_json row = {{"variant", sweep.variants[v].folder},
                        {"values", values},
                        {"set", sweep.variants[v].overrides}};
    row.update(rows[v]);
    variants.push_back(std::move(row));
  }
  return {{"name", name}, {"mode", sweep.mode}, {"keys", sweep.keys}, {"variants", variants}};
}

std::string text_table(const Sweep& sweep, const std::vector<ordered_json>& rows) {
  constexpr std::size_t widest = 40;
  const auto table = cells(sweep, rows);
  std::string text;
  std::vector<std::size_t> widths(table[0].size(), 0);
  for (std::size_t c = 1; c < widths.size(); ++c) {
    for (std::size_t r = 1; r < table.size(); ++r) {
      widths[c] = std::max(widths[c], std::min(widest, table[r][c].size()));
    }
    if (widths[c] > 0) widths[c] = std::max(widths[c], table[0][c].size());
  }
  for (const auto& line : table) {
    // The folder says again what the values say, but for long ones.
    for (std::size_t c = 1; c < line.size(); ++c) {
      if (widths[c] == 0) continue;
      const std::string& full = line[c];
      const std::string shown =
          full.size() <= widths[c] ? full : full.substr(0, widest - 3) + "...";
      text += fmt::format("  {:>{}}", shown, widths[c]);
    }
    text += "\n";
  }
  return text;
}

}  // namespace carillon::dataset::sweep
