#include "cli/export/exported_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "cli/columns.hpp"
#include "core/error.hpp"

namespace carillon::cli {

namespace {

/// Names of the values of a row: the column's own, or with a suffix for each place.
std::vector<std::string> value_names(const std::string& name, const core::Extent& extent) {
  std::vector<std::string> names = {name};
  for (std::size_t axis = 1; axis < extent.size(); ++axis) {
    if (extent[axis] == 1) continue;
    const bool is_vector = axis + 1 == extent.size() && extent[axis] == 3;
    std::vector<std::string> longer;
    for (const std::string& start : names) {
      for (std::uint64_t i = 0; i < extent[axis]; ++i) {
        longer.push_back(is_vector ? fmt::format("{}_{}", start, "xyz"[i])
                                   : fmt::format("{}_{}", start, i));
      }
    }
    names = std::move(longer);
  }
  return names;
}

/// The shortest number that is the same in single precision: 0.1, not 0.10000000149.
double shortest(float value) {
  return std::isfinite(value) ? std::stod(fmt::format("{}", value)) : static_cast<double>(value);
}

/// Every `width`-th value from `place` on.
template <class To, class From>
std::vector<To> component(const std::vector<From>& all, std::size_t width, std::size_t place) {
  std::vector<To> values;
  for (std::size_t i = place; i < all.size(); i += width) {
    if constexpr (std::is_same_v<From, float>) {
      values.push_back(shortest(all[i]));
    } else {
      values.push_back(static_cast<To>(all[i]));
    }
  }
  return values;
}

}  // namespace

ExportedRows::ExportedRows(const core::Hdf5Group& index, const std::string& split) {
  if (!index.has("key")) throw core::InputError("the dataset has no samples");
  if (!index.has(split) || index.is_group(split) || !index.is_text(split)) {
    throw core::InputError(fmt::format("there is no split \"{}\"", split),
                           "split_shape holds out whole bodies, split_strike strikes of each body");
  }
  keys_ = index.read<std::string>("key");
  parts_ = index.read<std::string>(split);
  ids_ = index.read<std::uint64_t>("id");
  for (const std::string& name : index.names()) {
    if (!index.is_group(name)) add(index, name);
  }
}

void ExportedRows::add(const core::Hdf5Group& index, const std::string& name) {
  const core::Extent extent = index.extent(name);
  const std::uint64_t width =
      std::accumulate(extent.begin() + 1, extent.end(), std::uint64_t{1}, std::multiplies<>());
  if (width > kLongestShown || width == 0) return;
  const std::string type = index.element_type(name);
  const std::string unit = type == "text" ? "" : index.text_attribute("unit", name);
  const auto add_all = [&]<class To, class From>(To, From) {
    const std::vector<From> all = index.read<From>(name);
    const std::vector<std::string> names = value_names(name, extent);
    for (std::size_t i = 0; i < names.size(); ++i) {
      columns_.push_back({names[i], unit, component<To>(all, names.size(), i)});
    }
  };
  if (type == "text") {
    columns_.push_back({name, "", index.read<std::string>(name)});
  } else if (type == "float32") {
    add_all(double{}, float{});
  } else if (type == "float64") {
    add_all(double{}, double{});
  } else if (type == "uint64") {
    add_all(std::uint64_t{}, std::uint64_t{});
  } else {
    add_all(std::int64_t{}, std::int64_t{});
  }
}

nlohmann::ordered_json ExportedRows::values(std::size_t row) const {
  nlohmann::ordered_json values = nlohmann::ordered_json::object();
  for (const Column& column : columns_) {
    std::visit(
        [&](const auto& all) {
          const auto& value = all[row];
          if constexpr (std::is_same_v<std::decay_t<decltype(value)>, double>) {
            if (!std::isfinite(value)) {
              values[column.name] = nullptr;
              return;
            }
          }
          values[column.name] = value;
        },
        column.values);
  }
  return values;
}

std::string csv_cell(const nlohmann::ordered_json& value) {
  if (value.is_null()) return "";
  if (!value.is_string()) return value.dump();
  std::string text = value.get<std::string>();
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  for (std::size_t at = text.find('"'); at != std::string::npos; at = text.find('"', at + 2)) {
    text.insert(at, 1, '"');
  }
  return '"' + text + '"';
}

}  // namespace carillon::cli
