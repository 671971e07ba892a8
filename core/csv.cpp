#include "core/csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/text.hpp"

namespace carillon::core {

namespace {

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos && trimmed(text) == text) return text;
  std::string cell = "\"";
  for (const char c : text) cell.append(c == '"' ? 2 : 1, c);
  return cell + '"';
}

}  // namespace

std::string csv_line(const std::vector<std::string>& cells) {
  std::string line;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i > 0) line += ',';
    line += quoted(cells[i]);
  }
  return line + '\n';
}

std::string csv_number(double value, int digits) {
  return std::isnan(value) ? "" : fmt::format("{:.{}g}", value, digits);
}

std::string csv_value(const nlohmann::ordered_json& value) {
  if (value.is_null()) return "";
  return value.is_string() ? value.get<std::string>() : value.dump();
}

std::vector<std::string> csv_cells(std::string_view line) {
  std::vector<std::string> cells;
  std::string cell;
  bool quoted = false, in_quotes = false;
  const auto end_cell = [&] {
    cells.push_back(quoted ? cell : std::string(trimmed(cell)));
    cell.clear();
    quoted = false;
  };
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (in_quotes) {
      if (c != '"') {
        cell += c;
      } else if (i + 1 < line.size() && line[i + 1] == '"') {
        cell += c;
        ++i;
      } else {
        in_quotes = false;
      }
    } else if (c == ',') {
      end_cell();
    } else if (c == '"' && trimmed(cell).empty()) {
      cell.clear();
      quoted = in_quotes = true;
    } else if (!quoted) {
      cell += c;
    }
  }
  if (in_quotes) throw InputError(fmt::format("a quote is not closed: {}", line));
  end_cell();
  return cells;
}

std::optional<std::size_t> CsvTable::column(std::string_view name) const {
  const auto found = std::find(head.cells.begin(), head.cells.end(), name);
  if (found == head.cells.end()) return {};
  return static_cast<std::size_t>(found - head.cells.begin());
}

CsvTable read_csv(const std::filesystem::path& path, char comment) {
  std::string text = read_file(path);
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  std::istringstream lines(text);
  CsvTable table;
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    const std::string_view content = trimmed(line);
    if (content.empty() || (comment != '\0' && content.front() == comment)) continue;
    CsvRow row{fmt::format("{}:{}", path.string(), number), {}};
    try {
      row.cells = csv_cells(line);
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}: {}", row.place, error.message()), error.hint());
    }
    const std::size_t minimum = std::max<std::size_t>(1, table.head.cells.size());
    while (row.cells.size() > minimum && row.cells.back().empty()) row.cells.pop_back();
    if (table.head.cells.empty()) {
      table.head = std::move(row);
    } else {
      table.rows.push_back(std::move(row));
    }
  }
  return table;
}

}  // namespace carillon::core
