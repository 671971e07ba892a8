#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace carillon::core {

/// Cells of one line of a CSV file (RFC 4180, but for line breaks within quotes): between commas,
/// within quotes commas too, a quote there doubled. Blanks around cells that are not in quotes are
/// dropped, and a carriage return at the end.
/// @throws InputError  a quote that is not closed
std::vector<std::string> csv_cells(std::string_view line);

/// A text as a cell (RFC 4180): in quotes, a quote there doubled, where it holds a comma, a quote,
/// a line break, or a blank at either end.
std::string csv_cell(std::string_view text);

}  // namespace carillon::core
