#pragma once

#include <cstdint>
#include <string>

#include "core/hdf5.hpp"

namespace carillon::dataset::exporters {

/// Rows of an HDF5 dataset as NumPy files (format 1.0).
class NpyRows {
 public:
  /// @throws InputError  texts, or elements that have no NumPy type
  NpyRows(const core::Hdf5Group& group, const std::string& name);

  /// One row as the bytes of a .npy file.
  std::string row(std::uint64_t row) const;

 private:
  const core::Hdf5Group& group_;
  std::string name_, type_, header_;
};

}  // namespace carillon::dataset::exporters
