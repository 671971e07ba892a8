#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/hdf5.hpp"
#include "dataset/exporters/exported_rows.hpp"

namespace carillon::dataset::exporters {

/// What a data card says of an export beside its rows.
struct CardSource {
  std::string name;                      ///< of the dataset
  nlohmann::ordered_json said;           ///< dataset.json; an empty object where there is none
  std::string format;                    ///< `wav`, `webdataset` or `lhotse`
  std::string split;                     ///< column that says which part a sample is in
  std::vector<std::string> arrays;       ///< columns that are .npy members
  std::vector<std::string> hidden = {};  ///< parts without labels
};

/// README.md of an export, the card of a dataset on the Hugging Face Hub: a YAML header with the
/// licence, the files of each part and the type of each column; then what the dataset is, its
/// columns with units, how it was made, and what may be done with it.
/// @param index  index.h5 of the dataset
std::string data_card(const CardSource& source, const ExportedRows& rows,
                      const core::Hdf5Group& index);

}  // namespace carillon::dataset::exporters
