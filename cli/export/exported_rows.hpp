#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <variant>
#include <vector>

#include "core/hdf5.hpp"

namespace carillon::cli {

/// What an export tells of a dataset's samples: every column of its index with a few values a row,
/// of vectors one for each component (`position_x`).
class ExportedRows {
 public:
  struct Column {
    std::string name, unit;
    std::variant<std::vector<double>, std::vector<std::int64_t>, std::vector<std::uint64_t>,
                 std::vector<std::string>>
        values;
  };

  /// @param index  index.h5
  /// @param split  column that says which part a sample is in
  /// @throws InputError  no samples, or no such column
  ExportedRows(const core::Hdf5Group& index, const std::string& split);

  std::size_t size() const { return keys_.size(); }
  const std::string& key(std::size_t row) const { return keys_[row]; }
  /// `train`, `validation` or `test`.
  const std::string& part(std::size_t row) const { return parts_[row]; }
  /// Random but fixed: rows in its order are shuffled.
  std::uint64_t id(std::size_t row) const { return ids_[row]; }

  const std::vector<Column>& columns() const { return columns_; }
  /// A sample's values by column; null where there is no number.
  nlohmann::ordered_json values(std::size_t row) const;

 private:
  void add(const core::Hdf5Group& index, const std::string& name);

  std::vector<Column> columns_;
  std::vector<std::string> keys_, parts_;
  std::vector<std::uint64_t> ids_;
};

/// A cell of a CSV file: as it is read back, nothing for null.
std::string csv_cell(const nlohmann::ordered_json& value);

}  // namespace carillon::cli
