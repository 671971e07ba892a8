#pragma once

#include <sys/stat.h>

#include <string>
#include <vector>

#include "core/detail/hdf5_detail.hpp"
#include "core/handle.hpp"

namespace carillon::core::hdf5 {

/// Chunks of whole rows that were written as core/hdf5_arrays.cpp does it, read without HDF5's own
/// way, which takes ten times as long for a row. Where they lie is asked of HDF5 once; afterwards
/// the file can be closed.
class ChunkReader {
 public:
  /// Buffers of one reading, which many readers share.
  struct Scratch {
    std::vector<unsigned char> packed, planes, values;
  };

  /// @param path  of the dataset's file
  ChunkReader(const OpenDataset& dataset, std::string path);

  /// Rows that are decompressed together; 0: each lies by itself.
  std::uint64_t rows() const { return rows_; }

  /// Asks where all chunks lie; once.
  void locate(const OpenDataset& dataset);
  /// Whether every row can be read while HDF5 has the file closed.
  bool is_complete() const { return complete_; }

  /// Rows [first, first + count) of one chunk. The file is opened for it and stays open.
  /// @param type  the values' in memory
  /// @return false where HDF5 itself must read them: another type, a file that is another by now,
  ///         or a damaged one
  bool read(hid_t type, std::uint64_t first, std::uint64_t count, void* to, Scratch& scratch);
  /// Closes the file until it is read again.
  void close() { descriptor_ = Descriptor(); }

 private:
  static int close_descriptor(int* descriptor);
  using Descriptor = Handle<int, close_descriptor, -1>;

  struct Place {
    haddr_t address = HADDR_UNDEF;
    hsize_t bytes = 0;
    unsigned skipped_filters = 0;
  };

  bool open();
  bool load(const Place& place, Scratch& scratch);

  std::string path_;
  std::uint64_t rows_ = 0;
  std::size_t element_size_ = 0, row_bytes_ = 0;
  Hdf5Object type_;  ///< the elements' own, where chunks can be read here
  Descriptor descriptor_;
  struct stat file_ = {};  ///< as it was when its chunks were located
  std::vector<Place> places_;
  bool located_ = false, complete_ = false;
};

}  // namespace carillon::core::hdf5
