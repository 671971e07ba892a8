#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/hdf5.hpp"

namespace carillon::dataset::stored {

/// A group of index.h5 whose rows many samples share, and the column that says which one each has.
struct SharedRows {
  const char* group;
  const char* column;
  const char* meaning;  ///< of the column
};
/// `shapes/` by `shape_index` and `appearances/` by `appearance_index`.
const std::vector<SharedRows>& shared_rows();

/// Where an array of an index is, and what says which of its rows is a sample's.
struct ArrayPlace {
  std::string path;    ///< "" where there is none of that name
  std::string column;  ///< "": as samples are numbered
};
/// A column of samples, or an array of the first shared rows that have it. Simulations share none.
ArrayPlace find_array(const core::Hdf5Group& index, const std::string& name);

}  // namespace carillon::dataset::stored
