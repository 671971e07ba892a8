#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "core/hdf5.hpp"

namespace carillon::core {

/// Arrays of a row that are shown to people and programs have so many values at the most; longer
/// ones are for the dataset.
inline constexpr std::size_t kLongestShown = 16;

/// The columns of one shard, filled sample by sample and written at once. Every sample must add the
/// same columns with the same extents: another one is an error of the program (std::logic_error).
class Columns {
 public:
  /// Adds one sample's value; `inner` is its extent (empty for a single value).
  template <class T>
  void add(const std::string& name, std::span<const T> values, const Extent& inner,
           const std::string& unit = "1") {
    Column& column = columns_[name];
    check(name, column, inner, values.size());
    if (column.rows == 0) {
      column.values = std::vector<T>{};
      column.inner = inner;
      column.unit = unit;
      order_.push_back(name);
    }
    auto& all = std::get<std::vector<T>>(column.values);
    all.insert(all.end(), values.begin(), values.end());
    ++column.rows;
  }
  template <class T>
  void add(const std::string& name, const T& value, const std::string& unit = "1") {
    add(name, std::span<const T>(&value, 1), {}, unit);
  }

  /// Puts the first `rows` rows of a shard with the same columns before those that were added.
  /// @throws FileError  a column is missing or has another extent
  void put_before(const Hdf5Group& shard, std::uint64_t rows);
  /// Every column as a dataset [rows, inner...] with its unit as an attribute.
  void write(const Hdf5Group& group) const;
  /// Calls visit(name, values, inner, unit) for every column in the order of adding; values are a
  /// span of the column's type, of all samples.
  template <class Visit>
  void each(const Visit& visit) const {
    for (const std::string& name : order_) {
      const Column& column = columns_.at(name);
      std::visit(
          [&](const auto& values) {
            using T = typename std::decay_t<decltype(values)>::value_type;
            visit(name, std::span<const T>(values), column.inner, column.unit);
          },
          column.values);
    }
  }
  /// The last sample's values by name; arrays of more values than `longest` are left out.
  nlohmann::json last_row(std::size_t longest = static_cast<std::size_t>(-1)) const;

 private:
  struct Column {
    std::variant<std::vector<float>, std::vector<double>, std::vector<std::int16_t>,
                 std::vector<std::int64_t>, std::vector<std::uint64_t>, std::vector<std::uint8_t>,
                 std::vector<std::string>>
        values;
    Extent inner;
    std::string unit;
    std::uint64_t rows = 0;
  };
  static void check(const std::string& name, const Column& column, const Extent& inner,
                    std::size_t values);

  std::map<std::string, Column> columns_;
  std::vector<std::string> order_;
};

}  // namespace carillon::core
