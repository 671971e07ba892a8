#include "dataset/regenerate/detail/compare.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <set>

#include "core/numbers.hpp"

namespace carillon::dataset::regenerate {

using nlohmann::json;

namespace {

/// Longer arrays are described, not written out.
constexpr std::size_t max_values = 16;

template <class T>
std::string type_name() {
  if constexpr (std::is_same_v<T, std::string>) return "text";
  if constexpr (std::is_floating_point_v<T>) return fmt::format("float{}", 8 * sizeof(T));
  if constexpr (std::is_integral_v<T>) {
    return fmt::format("{}int{}", std::is_signed_v<T> ? "" : "u", 8 * sizeof(T));
  }
}

template <class T>
bool same(const T& a, const T& b) {
  if constexpr (std::is_floating_point_v<T>) {
    if (std::isnan(a) && std::isnan(b)) return true;
    return a == b && std::signbit(a) == std::signbit(b);
  } else {
    return a == b;
  }
}

template <class T>
json value_json(std::span<const T> values) {
  if (values.size() == 1) return values[0];
  if (values.size() <= max_values) return std::vector<T>(values.begin(), values.end());
  return fmt::format("{} values", values.size());
}

/// NaN stands where nothing is stored: beyond a simulation's last strike.
template <class T>
double value_or_nothing(T value) {
  return std::isnan(static_cast<double>(value)) ? 0.0 : static_cast<double>(value);
}

/// Energy of the difference over that of the stored values [dB].
template <class T>
double difference_db(std::span<const T> stored, std::span<const T> made) {
  double energy = 0, difference = 0;
  for (std::size_t i = 0; i < stored.size(); ++i) {
    const double a = value_or_nothing(stored[i]), b = value_or_nothing(made[i]);
    energy += a * a;
    difference += (a - b) * (a - b);
  }
  return core::decibels(difference / energy);
}

template <class T>
void compare_values(std::span<const T> made, const core::Hdf5Group& shard, const std::string& name,
                    std::uint64_t row, std::vector<ColumnDifference>& found) {
  const std::vector<T> all = shard.read_rows<T>(name, row, 1);
  const std::span<const T> stored(all);
  if (std::equal(stored.begin(), stored.end(), made.begin(), made.end(), same<T>)) return;
  found.push_back({name, value_json(stored), value_json(made)});
  if constexpr (std::is_arithmetic_v<T>) {
    if (made.size() > max_values) found.back().difference_db = difference_db(stored, made);
  }
}

/// Type, extent of a row and unit in words.
std::string kind(const std::string& type, const core::Extent& inner, const std::string& unit) {
  return fmt::format("{}[{}] in {}", type, fmt::join(inner, ", "), unit);
}

std::string stored_kind(const core::Hdf5Group& shard, const std::string& name) {
  core::Extent inner = shard.extent(name);
  if (!inner.empty()) inner.erase(inner.begin());
  return kind(shard.element_type(name), inner, shard.text_attribute("unit", name));
}

}  // namespace

std::vector<ColumnDifference> differences(const core::Columns& made, const core::Hdf5Group& shard,
                                          std::uint64_t row) {
  std::vector<ColumnDifference> found;
  std::set<std::string> names;
  made.each([&]<class T>(const std::string& name, std::span<const T> values,
                         const core::Extent& inner, const std::string& unit) {
    names.insert(name);
    if (!shard.has(name)) {
      found.push_back({name, nullptr, value_json(values)});
      return;
    }
    const std::string here = kind(type_name<T>(), inner, unit), there = stored_kind(shard, name);
    if (here != there) {
      found.push_back({name, there, here});
      return;
    }
    compare_values(values, shard, name, row, found);
  });
  for (const std::string& name : shard.names()) {
    if (names.contains(name)) continue;
    found.push_back({name, stored_kind(shard, name), nullptr});
  }
  return found;
}

}  // namespace carillon::dataset::regenerate
