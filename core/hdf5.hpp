#pragma once

#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace carillon::core {

/// Thin owners of HDF5 identifiers (C API). Object times are switched off, so equal contents give
/// equal bytes. Errors throw FileError with the file, the object and HDF5's reason.
class Hdf5Object {
 public:
  Hdf5Object() = default;
  Hdf5Object(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Hdf5Object(Hdf5Object&& other) noexcept { swap(other); }
  Hdf5Object& operator=(Hdf5Object&& other) noexcept {
    swap(other);
    return *this;
  }
  ~Hdf5Object() {
    if (id_ >= 0) close_(id_);
  }
  hid_t get() const { return id_; }

 private:
  void swap(Hdf5Object& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
  }
  hid_t id_ = -1;
  herr_t (*close_)(hid_t) = nullptr;
};

using Extent = std::vector<std::uint64_t>;

/// How an array lies on disk.
struct StorageOptions {
  std::uint64_t chunk_rows = 0;  ///< rows per chunk; 0: contiguous, uncompressed
  int deflate = 0;               ///< 0-9; needs chunks
};

/// One block of a virtual dataset: rows of a dataset in another file, placed one after the other.
struct VirtualSource {
  std::string file;     ///< relative to the folder of the file that joins
  std::string dataset;  ///< path inside it
  std::uint64_t rows;
  bool operator==(const VirtualSource&) const = default;
};

/// A file, or a group in it, that arrays and attributes are written to and read from.
/// Element types: float, double, int8/16/32/64, uint8/16/32/64, std::string (variable length
/// UTF-8). Names may be paths ("labels/material"); an array's groups are made, an object never
/// replaced.
class Hdf5Group {
 public:
  /// A new file for writing; one that is there is replaced.
  static Hdf5Group create_file(const std::filesystem::path& path);
  /// An existing file, for reading only.
  static Hdf5Group open_file(const std::filesystem::path& path);

  /// Hands everything written so far to the system. Closing does it too, but cannot report a full
  /// disk: call this last.
  void flush() const;

  Hdf5Group create_group(const std::string& name) const;
  Hdf5Group open_group(const std::string& name) const;
  bool has(const std::string& name) const;
  /// Whether a member is a group, not an array.
  bool is_group(const std::string& name) const;
  /// Members of this group in byte order.
  std::vector<std::string> names() const;

  /// @param values  row-major, as many as `extent` holds; an empty extent is a single value
  template <class T>
  void write(const std::string& name, std::span<const T> values, const Extent& extent,
             const StorageOptions& storage = {}) const;
  template <class T>
  std::vector<T> read(const std::string& name) const;
  /// Rows [first, first + count) along the first axis; Hdf5Rows for who reads more than once.
  template <class T>
  std::vector<T> read_rows(const std::string& name, std::uint64_t first, std::uint64_t count) const;
  Extent extent(const std::string& name) const;
  /// Whether a dataset holds texts.
  bool is_text(const std::string& name) const;
  /// What the elements of a dataset are on disk: `float32`, `float64`, `int8` to `int64`, `uint8`
  /// to `uint64`, `text`, or `other`.
  std::string element_type(const std::string& name) const;
  /// What a virtual dataset is joined from, in order; empty for one that holds its values itself.
  std::vector<VirtualSource> virtual_sources(const std::string& name) const;

  /// A dataset to be filled by rows, zero until then. T is the stored type.
  template <class T>
  void create(const std::string& name, const Extent& extent,
              const StorageOptions& storage = {}) const;
  template <class T>
  void write_rows(const std::string& name, std::uint64_t first, std::span<const T> values) const;

  /// A dataset whose rows are those of `sources`, one after the other; element type and inner
  /// extent are taken from the first source's file. Rows of a file that is lost later are errors
  /// here; who reads them by HDF5 alone finds NaN, or -32,768 in 16 bits.
  /// @param folder  that of the file that joins
  void write_virtual(const std::string& name, const std::filesystem::path& folder,
                     std::span<const VirtualSource> sources) const;

  /// Attributes on this group, or on one of its objects with `object`; one that is there is
  /// replaced. Texts are of variable length, which h5py reads as str.
  void write_attribute(const std::string& name, const std::string& value,
                       const std::string& object = ".") const;
  void write_attribute(const std::string& name, double value,
                       const std::string& object = ".") const;
  void write_attribute(const std::string& name, std::int64_t value,
                       const std::string& object = ".") const;
  std::string text_attribute(const std::string& name, const std::string& object = ".") const;
  double number_attribute(const std::string& name, const std::string& object = ".") const;
  /// All attributes, texts as they are, numbers written out.
  std::map<std::string, std::string> attributes(const std::string& object = ".") const;

 private:
  friend class Hdf5Rows;
  Hdf5Group(Hdf5Object id, std::string file) : id_(std::move(id)), file_(std::move(file)) {}
  Hdf5Object id_;
  std::string file_;
};

}  // namespace carillon::core
