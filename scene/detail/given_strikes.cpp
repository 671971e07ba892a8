#include "scene/detail/given_strikes.hpp"

#include <fmt/format.h>

#include <sstream>

#include "core/csv.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/units.hpp"

namespace carillon::scene {

using core::Dimension;
using core::InputError;

namespace {

const std::vector<std::string> known_columns = {
    "shape", "x_m", "y_m", "z_m", "dx", "dy", "dz", "impulse_ns", "peak_force_n", "contact_time_s"};

/// The cells of one line by column name.
class Row {
 public:
  Row(const std::vector<std::string>& columns, std::vector<std::string> cells, std::string place)
      : columns_(columns), cells_(std::move(cells)), place_(std::move(place)) {
    if (cells_.size() > columns_.size()) throw error("more cells than columns");
    cells_.resize(columns_.size());
  }
  bool has(const std::string& column) const { return !text(column).empty(); }
  std::string text(const std::string& column) const {
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (columns_[i] == column) return cells_[i];
    }
    return {};
  }
  double number(const std::string& column) const {
    if (!has(column)) throw error(fmt::format("no value for {}", column));
    try {
      return core::parse_quantity(text(column), Dimension::none);
    } catch (const InputError& problem) {
      throw error(fmt::format("{}: {}", column, problem.message()));
    }
  }
  InputError error(const std::string& message) const {
    return InputError(fmt::format("{}: {}", place_, message));
  }

 private:
  const std::vector<std::string>& columns_;
  std::vector<std::string> cells_;
  std::string place_;
};

GivenStrike parse_row(const Row& row) {
  GivenStrike strike;
  strike.shape = row.text("shape");
  strike.position = {row.number("x_m"), row.number("y_m"), row.number("z_m")};
  if (row.has("dx") || row.has("dy") || row.has("dz")) {
    const Vec3 direction(row.number("dx"), row.number("dy"), row.number("dz"));
    if (!(direction.norm() > 0)) throw row.error("the direction has no length");
    strike.direction = direction.normalized();
  }
  strike.contact_time = row.number("contact_time_s");
  if (!(strike.contact_time >= 0)) throw row.error("contact_time_s is negative");
  if (row.has("impulse_ns") == row.has("peak_force_n")) {
    throw row.error("give one of impulse_ns and peak_force_n");
  }
  strike.impulse = row.has("impulse_ns") ? row.number("impulse_ns")
                                         : row.number("peak_force_n") * strike.contact_time / 2;
  if (!(strike.impulse > 0)) throw row.error("the impulse is not positive");
  return strike;
}

}  // namespace

std::vector<GivenStrike> read_given_strikes(const std::string& path) {
  std::string text = core::read_file(path);
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);  // spreadsheets begin with a BOM
  std::istringstream lines(text);
  std::vector<std::string> columns;
  std::vector<GivenStrike> strikes;
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') continue;
    const std::string place = fmt::format("{}:{}", path, number);
    std::vector<std::string> cells = core::csv_cells(line);
    // Spreadsheets end every line with as many commas as the longest has.
    while (cells.size() > 1 && cells.back().empty()) cells.pop_back();
    if (!columns.empty()) {
      strikes.push_back(parse_row(Row(columns, std::move(cells), place)));
      continue;
    }
    columns = std::move(cells);
    for (const std::string& column : columns) {
      if (std::find(known_columns.begin(), known_columns.end(), column) == known_columns.end()) {
        const std::string near = core::nearest_name(column, known_columns);
        throw InputError(fmt::format("{}: unknown column \"{}\"", place, column),
                         near.empty()
                             ? fmt::format("columns are {}", fmt::join(known_columns, ", "))
                             : fmt::format("did you mean \"{}\"?", near));
      }
    }
  }
  if (strikes.empty()) throw InputError(fmt::format("{}: no strikes", path));
  return strikes;
}

}  // namespace carillon::scene
