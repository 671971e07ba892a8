#include "core/csv.hpp"

#include <fmt/format.h>

#include "core/error.hpp"

namespace carillon::core {

namespace {

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r");
  const auto last = text.find_last_not_of(" \t\r");
  return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

}  // namespace

std::vector<std::string> csv_cells(std::string_view line) {
  std::vector<std::string> cells;
  std::string cell;
  bool quoted = false, in_quotes = false;
  const auto end_cell = [&] {
    cells.push_back(quoted ? cell : trimmed(cell));
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

std::string csv_cell(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos &&
      trimmed(std::string(text)) == text) {
    return std::string(text);
  }
  std::string cell = "\"";
  for (const char c : text) cell.append(c == '"' ? 2 : 1, c);
  return cell + '"';
}

}  // namespace carillon::core
