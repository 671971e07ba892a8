#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace carillon::core {

/// What the header of a NumPy file says of its array, whose elements are little-endian and lie row
/// by row (C order).
struct NpyHeader {
  std::string type;                   ///< "float32", "int64", ...
  std::vector<std::uint64_t> extent;  ///< of each axis; none for a single number
};

/// The bytes before the elements, format 1.0.
/// @throws InputError  a type that has no name in NumPy
std::string npy_header(const NpyHeader& header);

/// The way back, of formats 1.0, 2.0 and 3.0.
/// @param bytes   the beginning of a file, or all of it
/// @param offset  becomes the place of the first element [byte]
/// @throws InputError  not a NumPy file, a header that is cut off or malformed, big-endian
///                     elements, Fortran order, or elements that are no numbers: says which, and
///                     how to save the array anew
NpyHeader parse_npy_header(std::string_view bytes, std::uint64_t& offset);

/// An array in a file, of which rows are read when they are asked for: recordings of gigabytes
/// take no memory.
class NpyFile {
 public:
  /// @throws FileError   cannot be read
  /// @throws InputError  as parse_npy_header(), or fewer bytes than the extent says; names the file
  explicit NpyFile(std::filesystem::path path);

  const std::filesystem::path& path() const { return path_; }
  const std::string& type() const { return header_.type; }
  const std::vector<std::uint64_t>& extent() const { return header_.extent; }
  std::uint64_t rows() const { return header_.extent.empty() ? 1 : header_.extent.front(); }
  /// Elements of a row: the product of the extents after the first.
  std::uint64_t row_size() const { return row_size_; }

  /// Elements of `count` rows, one row after the other; integers beyond 2^53 are rounded.
  /// @throws InputError  rows that there are not
  /// @throws FileError   cannot be read
  std::vector<double> read_rows(std::uint64_t first, std::uint64_t count) const;

 private:
  std::filesystem::path path_;
  NpyHeader header_;
  std::uint64_t offset_ = 0;    ///< of the first element [byte]
  std::uint64_t row_size_ = 1;  ///< elements
};

}  // namespace carillon::core
