#include "eval/features/feature_table.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>

#include "core/error.hpp"
#include "core/files.hpp"

namespace carillon::eval::features {

namespace {

using core::InputError;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> fields;
  for (;;) {
    // A comma between quotes belongs to the text.
    std::size_t comma = 0;
    for (bool quoted = false; comma < line.size() && (quoted || line[comma] != ','); ++comma) {
      if (line[comma] == '"') quoted = !quoted;
    }
    if (comma == line.size()) comma = std::string_view::npos;
    std::string_view field = trimmed(line.substr(0, comma));
    if (field.size() >= 2 && field.front() == '"' && field.back() == '"') {
      field = field.substr(1, field.size() - 2);
    }
    fields.push_back(field);
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

/// Where a column stands.
using Place = std::optional<std::size_t>;

/// One line of the table.
struct Line {
  std::string place;  ///< "features.csv:3"
  std::vector<std::string_view> fields;

  double number(std::size_t column, const char* name, bool zero_allowed) const {
    if (column >= fields.size()) {
      throw InputError(fmt::format("{}: {} values, but {} stands at the {}th", place, fields.size(),
                                   name, column + 1));
    }
    const std::string_view text = fields[column];
    double value = 0;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
    if (read.ec != std::errc() || read.ptr != text.data() + text.size()) {
      throw InputError(fmt::format("{}: {} is \"{}\", which is no number", place, name, text));
    }
    if (!std::isfinite(value) || value < 0 || (value == 0 && !zero_allowed)) {
      throw InputError(
          fmt::format("{}: {} must be {}, not {}", place, name,
                      zero_allowed ? "finite and not negative" : "positive and finite", text),
          "leave out lines of what does not decay or could not be measured");
    }
    return value;
  }

  /// An error may be left empty or be nan: not known.
  double error(Place column, const char* name) const {
    if (!column || *column >= fields.size()) return kUnknown;
    const std::string_view text = fields[*column];
    if (text.empty() || text == "nan" || text == "-nan") return kUnknown;
    return number(*column, name, true);
  }
};

}  // namespace

std::vector<Feature> read_feature_table(const std::filesystem::path& path) {
  std::string content = core::read_file(path);
  if (content.starts_with("\xef\xbb\xbf")) content.erase(0, 3);  // as spreadsheets write it
  std::istringstream text(content);
  std::vector<Feature> features;
  std::vector<std::string> names;
  const auto column = [&](const char* name) -> Place {
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i] == name) return i;
    }
    return {};
  };
  std::string line;
  for (int number = 1; std::getline(text, line); ++number) {
    if (trimmed(line).empty() || trimmed(line).front() == '#') continue;
    const Line row{fmt::format("{}:{}", path.string(), number), split(line)};
    if (names.empty()) {
      for (const auto& field : row.fields) names.emplace_back(field);
      for (const char* name : {"frequency_hz", "decay_rate_per_s"}) {
        if (column(name)) continue;
        throw InputError(fmt::format("{}: no column \"{}\"", row.place, name),
                         "the first line names the columns: frequency_hz,decay_rate_per_s");
      }
      continue;
    }
    Feature feature;
    feature.frequency = row.number(*column("frequency_hz"), "frequency_hz", false);
    feature.decay_rate = row.number(*column("decay_rate_per_s"), "decay_rate_per_s", false);
    feature.frequency_error = row.error(column("frequency_error_hz"), "frequency_error_hz");
    feature.decay_rate_error =
        row.error(column("decay_rate_error_per_s"), "decay_rate_error_per_s");
    feature.amplitude = row.error(column("amplitude"), "amplitude");
    feature.amplitude_error = kUnknown;
    const Place reverberant = column("reverberant");
    feature.reverberant = reverberant && row.number(*reverberant, "reverberant", true) != 0;
    features.push_back(feature);
  }
  return features;
}

}  // namespace carillon::eval::features
