#include "scene/detail/given_strikes.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/csv.hpp"
#include "core/error.hpp"
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
  Row(const core::CsvTable& table, const core::CsvRow& row) : table_(table), row_(row) {
    if (row.cells.size() > table.head.cells.size()) throw error("more cells than columns");
  }
  bool has(const std::string& column) const { return !text(column).empty(); }
  std::string text(const std::string& column) const {
    const auto at = table_.column(column);
    return at && *at < row_.cells.size() ? row_.cells[*at] : std::string();
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
    return InputError(fmt::format("{}: {}", row_.place, message));
  }

 private:
  const core::CsvTable& table_;
  const core::CsvRow& row_;
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
  const core::CsvTable table = core::read_csv(path, '#');
  for (const std::string& column : table.head.cells) {
    if (std::find(known_columns.begin(), known_columns.end(), column) != known_columns.end()) {
      continue;
    }
    const std::string near = core::nearest_name(column, known_columns);
    throw InputError(fmt::format("{}: unknown column \"{}\"", table.head.place, column),
                     near.empty() ? fmt::format("columns are {}", fmt::join(known_columns, ", "))
                                  : fmt::format("did you mean \"{}\"?", near));
  }
  std::vector<GivenStrike> strikes;
  for (const core::CsvRow& row : table.rows) strikes.push_back(parse_row(Row(table, row)));
  if (strikes.empty()) throw InputError(fmt::format("{}: no strikes", path));
  return strikes;
}

}  // namespace carillon::scene
