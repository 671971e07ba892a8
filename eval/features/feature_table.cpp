#include "eval/features/feature_table.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

#include "core/csv.hpp"
#include "core/error.hpp"
#include "core/numbers.hpp"

namespace carillon::eval::features {

namespace {

using core::InputError;

/// Where a column stands.
using Place = std::optional<std::size_t>;

/// One line of the table.
struct Line {
  const core::CsvRow& row;

  double number(std::size_t column, const char* name, bool zero_allowed) const {
    if (column >= row.cells.size()) {
      throw InputError(fmt::format("{}: {} values, but {} stands at the {}th", row.place,
                                   row.cells.size(), name, column + 1));
    }
    const std::string_view text = row.cells[column];
    double value = 0;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
    if (read.ec != std::errc() || read.ptr != text.data() + text.size()) {
      throw InputError(fmt::format("{}: {} is \"{}\", which is no number", row.place, name, text));
    }
    if (!std::isfinite(value) || value < 0 || (value == 0 && !zero_allowed)) {
      throw InputError(
          fmt::format("{}: {} must be {}, not {}", row.place, name,
                      zero_allowed ? "finite and not negative" : "positive and finite", text),
          "leave out lines of what does not decay or could not be measured");
    }
    return value;
  }

  /// An error may be left empty or be nan: not known.
  double error(Place column, const char* name) const {
    if (!column || *column >= row.cells.size()) return core::nan;
    const std::string_view text = row.cells[*column];
    if (text.empty() || text == "nan" || text == "-nan") return core::nan;
    return number(*column, name, true);
  }
};

}  // namespace

std::vector<Feature> read_feature_table(const std::filesystem::path& path) {
  const core::CsvTable table = core::read_csv(path, '#');
  if (table.head.cells.empty()) return {};
  for (const char* name : {"frequency_hz", "decay_rate_per_s"}) {
    if (table.column(name)) continue;
    throw InputError(fmt::format("{}: no column \"{}\"", table.head.place, name),
                     "the first line names the columns: frequency_hz,decay_rate_per_s");
  }
  const std::size_t frequency = *table.column("frequency_hz");
  const std::size_t decay_rate = *table.column("decay_rate_per_s");
  const Place reverberant = table.column("reverberant");
  std::vector<Feature> features;
  for (const core::CsvRow& row : table.rows) {
    const Line line{row};
    Feature feature;
    feature.frequency = line.number(frequency, "frequency_hz", false);
    feature.decay_rate = line.number(decay_rate, "decay_rate_per_s", false);
    feature.frequency_error = line.error(table.column("frequency_error_hz"), "frequency_error_hz");
    feature.decay_rate_error =
        line.error(table.column("decay_rate_error_per_s"), "decay_rate_error_per_s");
    feature.amplitude = line.error(table.column("amplitude"), "amplitude");
    feature.amplitude_error = core::nan;
    feature.reverberant = reverberant && line.number(*reverberant, "reverberant", true) != 0;
    features.push_back(feature);
  }
  return features;
}

}  // namespace carillon::eval::features
