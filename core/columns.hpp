#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "core/hdf5.hpp"

namespace carillon::core {

/// Arrays of a row that are shown to people and programs have so many values at the most; longer
/// ones are for the dataset.
inline constexpr std::size_t longest_shown = 16;

/// What a column holds, in whichever shard.
struct ColumnRule {
  const char* name;  ///< "alpha" stands for alpha1, alpha2, ..., "label_" for all that begin so
  const char* type;  ///< as Hdf5Group::element_type; "": float32 or int16, as configured
  /// Extent of a row: "" a single value; numbers and names of any number, as in "contacts,3"; or
  /// "audio", "mel", "listeners", as configured.
  const char* inner;
  const char* units;  ///< those that may be, separated by '|'; "": any
  const char* when;  ///< "always"; "may"; "struck", of objects that are struck; or the effects that
                     ///< bring it, separated by '|'
  const char* meaning;  ///< a line of Markdown
  bool may_be_nan = false;
};

/// The rule of a column; null for one that there is none for.
const ColumnRule* find_rule(std::span<const ColumnRule> rules, std::string_view column);

/// What values of T are on disk, as Hdf5Group::element_type; "": T is no element.
template <class T>
constexpr std::string_view element_type() {
  if constexpr (std::is_same_v<T, float>) return "float32";
  if constexpr (std::is_same_v<T, double>) return "float64";
  if constexpr (std::is_same_v<T, std::int16_t>) return "int16";
  if constexpr (std::is_same_v<T, std::int64_t>) return "int64";
  if constexpr (std::is_same_v<T, std::uint64_t>) return "uint64";
  if constexpr (std::is_same_v<T, std::uint8_t>) return "uint8";
  if constexpr (std::is_same_v<T, std::string>) return "text";
  return "";
}

/// The columns of one shard, filled sample by sample and written at once. Every sample must add the
/// same columns with the same extents, and each as its rule has it: anything else is an error of
/// the program (std::logic_error).
class Columns {
 public:
  /// @param rules  of all columns that may be added; outlive this
  explicit Columns(std::span<const ColumnRule> rules) : rules_(rules) {}

  /// Adds one sample's value; `inner` is its extent (empty for a single value).
  /// @param unit  where the rule has several
  template <class T>
  void add(const std::string& name, std::span<const T> values, const Extent& inner,
           const std::string& unit = "") {
    Column& column = columns_[name];
    check(name, column, inner, values.size());
    if (column.rows == 0) {
      column.values = std::vector<T>{};
      column.inner = inner;
      column.unit = unit_of(name, element_type<T>(), inner.size(), unit);
      order_.push_back(name);
    }
    auto& all = std::get<std::vector<T>>(column.values);
    all.insert(all.end(), values.begin(), values.end());
    ++column.rows;
  }
  template <class T>
  requires(!element_type<T>().empty()) void add(const std::string& name, const T& value,
                                                const std::string& unit = "") {
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
  /// The unit that a column's rule has or lets be.
  std::string unit_of(const std::string& name, std::string_view type, std::size_t axes,
                      const std::string& unit) const;

  std::span<const ColumnRule> rules_;
  std::map<std::string, Column> columns_;
  std::vector<std::string> order_;
};

}  // namespace carillon::core
