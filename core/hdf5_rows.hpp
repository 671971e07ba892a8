#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/hdf5.hpp"

namespace carillon::core {

/// Rows of an array, in any order, for whoever reads many of them: what they lie in is opened once.
/// Those of a virtual dataset are read from the files that it joins, opened when first needed; some
/// hundred of them, the last ones used, stay open, and where chunks lie is kept of all. A file that
/// is not there, or not whole, is an error with its name; HDF5 itself would hand out fill values
/// for its rows.
class Hdf5Rows {
 public:
  /// @throws FileError  no such array, or a single value
  Hdf5Rows(const Hdf5Group& group, const std::string& name);
  Hdf5Rows(Hdf5Rows&&) noexcept;
  Hdf5Rows& operator=(Hdf5Rows&&) noexcept;
  ~Hdf5Rows();

  const Extent& extent() const;
  /// Opens every file that is joined here, so that a lost one is noticed before work begins.
  /// @throws FileError  names the first that is not there, or not whole
  void require_files() const;
  /// Values of one row.
  std::uint64_t width() const;

  /// @param rows    each below extent()[0]; reading is fastest where neighbours follow one another
  /// @param values  [rows, width()], row-major. Of the types of Hdf5Group; numbers are converted
  /// @throws FileError  names the file that cannot be read
  template <class T>
  void read(std::span<const std::uint64_t> rows, std::span<T> values) const;

  /// Rows [first, first + count).
  template <class T>
  std::vector<T> read(std::uint64_t first, std::uint64_t count) const;

 private:
  struct Array;
  std::unique_ptr<Array> array_;
};

}  // namespace carillon::core
