#include "eval/features/feature_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>

#include "core/csv.hpp"
#include "core/error.hpp"
#include "core/numbers.hpp"
#include "core/text.hpp"

namespace carillon::eval::features {

namespace {

using core::InputError;

/// What a column may hold.
enum class Quantity {
  frequency,
  decay_rate,
  damping_ratio,
  quality_factor,
  loss_factor,
  t60,
  amplitude,
  reverberant
};

struct Unit {
  const char* name;  ///< as a header has it between brackets, or after the last underscore
  double factor;     ///< to the unit that features have
};

struct Kind {
  Quantity quantity;
  std::vector<const char*> names;  ///< the first is the one that messages have
  std::vector<Unit> units;         ///< the first where the header has none
};

const std::vector<Kind>& kinds() {
  constexpr double decibel = std::numbers::ln10 / 20;
  static const std::vector<Kind> all = {
      {Quantity::frequency,
       {"frequency", "f", "freq"},
       {{"hz", 1}, {"khz", 1000}, {"rad/s", 1 / (2 * std::numbers::pi)}}},
      {Quantity::decay_rate,
       {"decay_rate", "d"},
       {{"1/s", 1}, {"per_s", 1}, {"db/s", decibel}, {"1/ms", 1000}}},
      {Quantity::damping_ratio,
       {"damping_ratio", "zeta"},
       {{"1", 1}, {"%", 0.01}, {"percent", 0.01}}},
      {Quantity::quality_factor, {"q", "quality_factor", "q_factor"}, {{"1", 1}}},
      {Quantity::loss_factor, {"loss_factor", "eta"}, {{"1", 1}, {"%", 0.01}, {"percent", 0.01}}},
      {Quantity::t60, {"t60"}, {{"s", 1}, {"ms", 1e-3}}},
      {Quantity::amplitude, {"amplitude"}, {{"", 1}}},
      {Quantity::reverberant, {"reverberant"}, {{"", 1}}}};
  return all;
}

/// A column of the table that is read.
struct Column {
  std::size_t place = 0;
  std::string name;  ///< as it stands in the header
  Quantity quantity = Quantity::frequency;
  bool error = false;
  double factor = 1;  ///< of its unit
};

/// "T60 Error" as "t60_error".
std::string plain(std::string_view text) {
  std::string name;
  for (const char letter : text) {
    const bool gap = letter == ' ' || letter == '_' || letter == '-';
    if (!gap) name += static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
    if (gap && !name.empty() && name.back() != '_') name += '_';
  }
  while (!name.empty() && name.back() == '_') name.pop_back();
  return name;
}

/// What a header's cell means, its unit taken off. Nothing where it is none of the kinds.
/// @throws InputError  a unit between brackets that the kind does not have
std::optional<Column> column_of(const core::CsvRow& head, std::size_t place) {
  const std::string text = head.cells[place];
  const std::size_t open = text.find_first_of("([");
  std::string name = plain(std::string_view(text).substr(0, open));
  std::string unit;
  if (open != std::string::npos) {
    const std::size_t close = text.find_first_of(")]", open);
    for (const char letter : std::string_view(text).substr(open + 1, close - open - 1)) {
      if (letter != ' ')
        unit += static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
    }
  }
  for (const Kind& kind : kinds()) {
    for (const char* known : kind.names) {
      if (!name.starts_with(known)) continue;
      std::string rest = name.substr(std::string_view(known).size());
      Column column{place, text, kind.quantity, false, kind.units.front().factor};
      if (rest.starts_with("_error")) {
        column.error = true;
        rest = rest.substr(6);
      }
      if (rest.empty() && unit.empty()) return column;
      if (!rest.empty() && !rest.starts_with("_")) continue;
      if (!rest.empty() && !unit.empty()) continue;
      const std::string asked = unit.empty() ? rest.substr(1) : unit;
      for (const Unit& one : kind.units) {
        if (asked != one.name) continue;
        column.factor = one.factor;
        return column;
      }
      if (unit.empty()) continue;
      std::vector<std::string> names;
      for (const Unit& one : kind.units) names.emplace_back(one.name);
      throw InputError(fmt::format("{}: column \"{}\" has the unit \"{}\", which is not known",
                                   head.place, text, unit),
                       fmt::format("{}", fmt::join(names, ", ")));
    }
  }
  return {};
}

/// One line of the table.
struct Line {
  const core::CsvRow& row;

  double number(const Column& column, bool zero_allowed) const {
    if (column.place >= row.cells.size()) {
      throw InputError(fmt::format("{}: {} values, but {} stands at the {}th", row.place,
                                   row.cells.size(), column.name, column.place + 1));
    }
    const std::string_view text = row.cells[column.place];
    const std::optional<double> number = core::number_in<double>(text);
    if (!number) {
      throw InputError(
          fmt::format("{}: {} is \"{}\", which is no number", row.place, column.name, text));
    }
    const double value = *number;
    if (!std::isfinite(value) || value < 0 || (value == 0 && !zero_allowed)) {
      throw InputError(
          fmt::format("{}: {} must be {}, not {}", row.place, column.name,
                      zero_allowed ? "finite and not negative" : "positive and finite", text),
          "leave out lines of what does not decay or could not be measured");
    }
    return value * column.factor;
  }

  bool empty(const Column& column) const {
    if (column.place >= row.cells.size()) return false;
    const std::string_view text = row.cells[column.place];
    return text.empty() || text == "nan" || text == "-nan";
  }

  /// An error may be left empty or be nan: not known.
  double error(const Column* column) const {
    if (column == nullptr || column->place >= row.cells.size() || empty(*column)) return core::nan;
    return number(*column, true);
  }
};

/// A decay rate [1/s] and how fast it changes with the number that it was made of.
struct Decay {
  double rate = 0;
  double slope = 1;
};

/// @param frequency  damped [Hz]
Decay decay_of(Quantity quantity, double value, double frequency) {
  const double omega = 2 * std::numbers::pi * frequency;
  // d = zeta omega_n, and omega is sqrt(1 - zeta^2) omega_n.
  const auto by_ratio = [&](double zeta, double slope) {
    const double rest = 1 - zeta * zeta;
    return Decay{omega * zeta / std::sqrt(rest), omega / (rest * std::sqrt(rest)) * slope};
  };
  switch (quantity) {
    case Quantity::damping_ratio:
      return by_ratio(value, 1);
    case Quantity::quality_factor:
      return by_ratio(0.5 / value, 0.5 / (value * value));
    case Quantity::loss_factor:
      return by_ratio(value / 2, 0.5);
    case Quantity::t60: {
      const double rate = std::log(1000.0) / value;
      return {rate, rate / value};
    }
    default:
      return {value, 1};
  }
}

/// The columns of a table by what they hold.
struct Columns {
  std::vector<Column> all;

  const Column* find(Quantity quantity, bool error) const {
    for (const Column& column : all) {
      if (column.quantity == quantity && column.error == error) return &column;
    }
    return nullptr;
  }
};

Columns columns_of(const core::CsvRow& head) {
  Columns columns;
  for (std::size_t place = 0; place < head.cells.size(); ++place) {
    const std::optional<Column> column = column_of(head, place);
    if (!column) continue;
    if (const Column* before = columns.find(column->quantity, column->error)) {
      throw InputError(fmt::format("{}: columns \"{}\" and \"{}\" hold the same", head.place,
                                   before->name, column->name),
                       "leave one out");
    }
    columns.all.push_back(*column);
  }
  if (columns.find(Quantity::frequency, false) == nullptr) {
    throw InputError(fmt::format("{}: no column \"frequency_hz\"", head.place),
                     "the first line names the columns: frequency_hz,decay_rate_per_s");
  }
  for (const Quantity quantity : {Quantity::decay_rate, Quantity::damping_ratio,
                                  Quantity::quality_factor, Quantity::loss_factor, Quantity::t60}) {
    if (columns.find(quantity, false) != nullptr) return columns;
  }
  throw InputError(
      fmt::format("{}: no column \"decay_rate_per_s\"", head.place),
      "decay_rate_per_s, or damping_ratio, q, loss_factor or t60_s; units may stand in "
      "brackets: T60 [ms]");
}

bool is_decay(const Column& column) {
  return !column.error && column.quantity != Quantity::frequency &&
         column.quantity != Quantity::amplitude && column.quantity != Quantity::reverberant;
}

/// The decay rate of a line by every column that has one, with its error.
void read_decay(const Line& line, const Columns& columns, Feature& feature) {
  // Tables round: what differs by less is the same.
  constexpr double rounding = 0.02;
  const Column* first = nullptr;
  const Column* last = nullptr;
  for (const Column& column : columns.all) {
    if (is_decay(column)) last = &column;
  }
  feature.decay_rate_error = core::nan;
  for (const Column& column : columns.all) {
    if (!is_decay(column)) continue;
    // One of several may be empty, not all.
    if (line.empty(column) && (first != nullptr || &column != last)) continue;
    const double value = line.number(column, false);
    const double limit = column.quantity == Quantity::damping_ratio ? 1
                         : column.quantity == Quantity::loss_factor ? 2
                                                                    : core::infinity;
    if (value >= limit || (column.quantity == Quantity::quality_factor && value <= 0.5)) {
      throw InputError(fmt::format("{}: {} is {}: what is damped so strongly does not ring",
                                   line.row.place, column.name, line.row.cells[column.place]),
                       "leave the line out; percentages have % in the header: zeta [%]");
    }
    const Decay decay = decay_of(column.quantity, value, feature.frequency);
    if (first == nullptr) {
      first = &column;
      feature.decay_rate = decay.rate;
    } else if (std::abs(decay.rate - feature.decay_rate) > rounding * feature.decay_rate) {
      throw InputError(
          fmt::format("{}: {} means a decay rate of {:.4g} 1/s, {} one of {:.4g} 1/s",
                      line.row.place, first->name, feature.decay_rate, column.name, decay.rate),
          "leave out the column that is wrong; a frequency is the damped one in Hz where its "
          "header "
          "has no unit");
    }
    const double error = decay.slope * line.error(columns.find(column.quantity, true));
    if (std::isnan(feature.decay_rate_error)) feature.decay_rate_error = error;
  }
}

}  // namespace

std::vector<Feature> read_feature_table(const std::filesystem::path& path) {
  const core::CsvTable table = core::read_csv(path, '#');
  if (table.head.cells.empty()) return {};
  const Columns columns = columns_of(table.head);
  const Column* reverberant = columns.find(Quantity::reverberant, false);
  std::vector<Feature> features;
  for (const core::CsvRow& row : table.rows) {
    const Line line{row};
    Feature feature;
    feature.frequency = line.number(*columns.find(Quantity::frequency, false), false);
    read_decay(line, columns, feature);
    feature.frequency_error = line.error(columns.find(Quantity::frequency, true));
    feature.amplitude = line.error(columns.find(Quantity::amplitude, false));
    feature.amplitude_error = core::nan;
    feature.reverberant = reverberant != nullptr && line.number(*reverberant, true) != 0;
    features.push_back(feature);
  }
  return features;
}

}  // namespace carillon::eval::features
