#include "dataset/exporters/exported_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <string_view>

#include "core/columns.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "scene/columns.hpp"

namespace carillon::dataset::exporters {

using nlohmann::ordered_json;

namespace {

/// Whether a row ends in the axes of space; three contacts, listeners or objects are none.
bool is_vector(const std::string& column) {
  const core::ColumnRule* rule = core::find_rule(scene::columns(), column);
  return rule != nullptr && std::string_view(rule->inner).ends_with('3');
}

std::vector<std::string> label_names(const std::string& column, const core::Extent& extent) {
  std::vector<std::string> names = {column};
  for (std::size_t axis = 1; axis < extent.size(); ++axis) {
    if (extent[axis] == 1) continue;
    const bool of_space = axis + 1 == extent.size() && is_vector(column);
    std::vector<std::string> longer;
    for (const std::string& start : names) {
      for (std::uint64_t i = 0; i < extent[axis]; ++i) {
        longer.push_back(of_space ? fmt::format("{}_{}", start, "xyz"[i])
                                  : fmt::format("{}_{}", start, i));
      }
    }
    names = std::move(longer);
  }
  return names;
}

template <class T>
ordered_json label_value(const T& value) {
  // The shortest number that is the same in single precision: 0.1, not 0.10000000149.
  if constexpr (std::is_same_v<T, float>) {
    return core::number_or_null(std::stod(fmt::format("{}", value)));
  } else if constexpr (std::is_same_v<T, double>) {
    return core::number_or_null(value);
  } else if constexpr (std::is_same_v<T, std::uint64_t>) {
    return fmt::format("{}", value);
  } else {
    return value;
  }
}

/// What readers of the labels take: 64 bits without a sign are beyond the numbers that JSON's
/// readers and int64 hold.
std::string label_type(const std::string& stored) {
  if (stored == "text" || stored == "uint64") return "text";
  return stored.starts_with("float") ? "float64" : "int64";
}

/// Puts a column's values of some rows into their labels.
/// @param order  places in `rows`, by ascending row
template <class T>
void read_labels(const core::Hdf5Group& index, const ExportedRows::Column& column,
                 std::span<const std::size_t> rows, std::span<const std::size_t> order,
                 std::vector<ordered_json>& labels) {
  // What lies so close together is read at once, as opening costs more than the rows between.
  constexpr std::size_t max_rows = 65536;
  const std::size_t width = column.labels.size();
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    const std::size_t first = rows[order[begin]];
    while (end < order.size() && rows[order[end]] - first < max_rows) ++end;
    const std::size_t count = rows[order[end - 1]] - first + 1;
    const std::vector<T> values = index.read_rows<T>(column.name, first, count);
    for (const std::size_t place : order.subspan(begin, end - begin)) {
      const T* row = values.data() + (rows[place] - first) * width;
      for (std::size_t k = 0; k < width; ++k) {
        labels[place][column.labels[k]] = label_value(row[k]);
      }
    }
  }
}

}  // namespace

ExportedRows::ExportedRows(const core::Hdf5Group& index, const std::string& split)
    : index_(index), split_(split) {
  if (!index.has("key")) throw core::InputError("the dataset has no samples");
  if (!index.has(split) || index.is_group(split) || !index.is_text(split)) {
    throw core::InputError(
        fmt::format("there is no split \"{}\"", split),
        "split_shape holds out whole objects, split_strike strikes of each object");
  }
  keys_ = index.read<std::string>("key");
  parts_ = index.read<std::string>(split);
  ids_ = index.read<std::uint64_t>("id");
  for (const std::string& name : index.names()) {
    if (!index.is_group(name)) add(name);
  }
}

void ExportedRows::add(const std::string& name) {
  const core::Extent extent = index_.extent(name);
  const std::uint64_t width =
      std::accumulate(extent.begin() + 1, extent.end(), std::uint64_t{1}, std::multiplies<>());
  if (width > core::longest_shown || width == 0) return;
  const std::string stored = index_.element_type(name);
  const std::string unit = stored == "text" ? "1" : index_.text_attribute("unit", name);
  columns_.push_back({name, stored, label_type(stored), unit, label_names(name, extent)});
}

void ExportedRows::hide(const Seal& seal) {
  hidden_.assign(size(), false);
  for (std::size_t row = 0; row < size(); ++row) {
    if (!seal.parts.contains(parts_[row])) continue;
    hidden_[row] = true;
    keys_[row] = seal.id_of(keys_[row]);
    ids_[row] = std::stoull(keys_[row].substr(0, 16), nullptr, 16);
  }
}

std::map<std::string, std::vector<std::size_t>> ExportedRows::by_part() const {
  std::map<std::string, std::vector<std::size_t>> parts;
  for (std::size_t row = 0; row < size(); ++row) parts[part(row)].push_back(row);
  for (auto& [part, rows] : parts) {
    if (!is_hidden(rows.front())) continue;
    std::sort(rows.begin(), rows.end(),
              [&](std::size_t a, std::size_t b) { return keys_[a] < keys_[b]; });
  }
  return parts;
}

std::vector<ordered_json> ExportedRows::labels(std::span<const std::size_t> rows) const {
  std::vector<ordered_json> labels(rows.size(), ordered_json::object());
  std::vector<std::size_t> order(rows.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return rows[a] < rows[b]; });
  for (const Column& column : columns_) {
    if (column.stored == "text") {
      read_labels<std::string>(index_, column, rows, order, labels);
    } else if (column.stored == "float32") {
      read_labels<float>(index_, column, rows, order, labels);
    } else if (column.stored == "float64") {
      read_labels<double>(index_, column, rows, order, labels);
    } else if (column.stored == "uint64") {
      read_labels<std::uint64_t>(index_, column, rows, order, labels);
    } else {
      read_labels<std::int64_t>(index_, column, rows, order, labels);
    }
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!is_hidden(rows[i])) continue;
    for (auto& [name, value] : labels[i].items()) value = nullptr;
    labels[i]["key"] = key(rows[i]);
    labels[i][split_] = part(rows[i]);
  }
  return labels;
}

const ordered_json& LabelStream::next() {
  constexpr std::size_t at_once = 16384;  // some 100 MB
  if (place_ == read_.size()) {
    const std::size_t count = std::min(at_once, ahead_.size());
    read_ = rows_.labels(ahead_.first(count));
    ahead_ = ahead_.subspan(count);
    place_ = 0;
  }
  return read_[place_++];
}

}  // namespace carillon::dataset::exporters
