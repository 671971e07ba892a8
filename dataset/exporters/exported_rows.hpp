#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/hdf5.hpp"
#include "dataset/exporters/seal.hpp"

namespace carillon::dataset::exporters {

/// What an export tells of a dataset's samples: every column of its index with a few values a row.
/// Keys, parts and ids of all samples are held; labels are read where they are asked for, as those
/// of a large set take gigabytes.
class ExportedRows {
 public:
  /// A column of the index, told as one column for each value of a row.
  struct Column {
    std::string name;
    std::string stored;               ///< as Hdf5Group::element_type
    std::string type;                 ///< of its labels: `text`, `int64` or `float64`
    std::string unit;                 ///< "1": a number alone, or a text
    std::vector<std::string> labels;  ///< `name`; `name_x`, ... of vectors; else `name_0`, ...
  };

  /// @param index  index.h5, which must outlive this
  /// @param split  column that says which part a sample is in
  /// @throws InputError  no samples, or no such column
  ExportedRows(const core::Hdf5Group& index, const std::string& split);

  /// From here on samples of the seal's parts go by its names, and have no labels but their part.
  void hide(const Seal& seal);
  bool is_hidden(std::size_t row) const { return !hidden_.empty() && hidden_[row]; }

  std::size_t size() const { return keys_.size(); }
  /// Or, of a hidden one, its name.
  const std::string& key(std::size_t row) const { return keys_[row]; }
  /// `train`, `validation` or `test`.
  const std::string& part(std::size_t row) const { return parts_[row]; }
  /// Rows of each part, ascending; hidden ones by their names, as neighbours are of one object.
  std::map<std::string, std::vector<std::size_t>> by_part() const;
  /// Random but fixed: rows in its order are shuffled.
  std::uint64_t id(std::size_t row) const { return ids_[row]; }

  const std::vector<Column>& columns() const { return columns_; }
  /// Labels of some rows, in their order: the values by label, null where there is no number. Each
  /// is of its column's type; an id, which takes all 64 bits, is a text.
  std::vector<nlohmann::ordered_json> labels(std::span<const std::size_t> rows) const;

 private:
  void add(const std::string& name);

  const core::Hdf5Group& index_;
  std::vector<Column> columns_;
  std::vector<std::string> keys_, parts_;
  std::vector<std::uint64_t> ids_;
  std::string split_;
  std::vector<bool> hidden_;  ///< empty: none is
};

/// Labels of samples that are wanted one after the other, read many at a time: rows in the order of
/// a shard lie all over the index.
class LabelStream {
 public:
  /// @param rows   must outlive this, as `order` must
  /// @param order  rows that will be wanted
  LabelStream(const ExportedRows& rows, std::span<const std::size_t> order)
      : rows_(rows), ahead_(order) {}

  /// Those of the next row, until the next call; not more often than there are rows.
  const nlohmann::ordered_json& next();

 private:
  const ExportedRows& rows_;
  std::span<const std::size_t> ahead_;  ///< not read yet
  std::vector<nlohmann::ordered_json> read_;
  std::size_t place_ = 0;
};

}  // namespace carillon::dataset::exporters
