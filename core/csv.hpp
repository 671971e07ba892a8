#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace carillon::core {

/// One line of a CSV file with its break (RFC 4180). A text that holds a comma, a quote, a line
/// break, or a blank at either end is put in quotes, a quote there doubled.
/// @param cells  texts; numbers as csv_number() or csv_value() write them
std::string csv_line(const std::vector<std::string>& cells);

/// A number as a cell, by so many significant digits; nothing for NaN.
std::string csv_number(double value, int digits);

/// A value as a cell: a text as it is, a number so that it reads back the same, nothing for null.
std::string csv_value(const nlohmann::ordered_json& value);

/// Cells of one line (RFC 4180, but for line breaks within quotes): between commas, within quotes
/// commas too, a quote there doubled. Blanks around cells that are not in quotes are dropped, and a
/// carriage return at the end.
/// @throws InputError  a quote that is not closed
std::vector<std::string> csv_cells(std::string_view line);

/// A line of a table, with where it stands: "features.csv:3".
struct CsvRow {
  std::string place;
  std::vector<std::string> cells;
};

/// A file whose first line names the columns.
struct CsvTable {
  CsvRow head;  ///< no cells where the file has no lines
  std::vector<CsvRow> rows;

  /// Which column has a name; nothing where none has.
  std::optional<std::size_t> column(std::string_view name) const;
};

/// Lines without a cell are passed over, and the byte order mark and the empty cells at the ends of
/// lines that spreadsheets write.
/// @param comment  lines that begin with it are passed over too; 0: there are none
/// @throws FileError   cannot be read
/// @throws InputError  a quote that is not closed; names file and line
CsvTable read_csv(const std::filesystem::path& path, char comment);

}  // namespace carillon::core
