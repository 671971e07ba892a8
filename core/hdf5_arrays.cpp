#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <type_traits>

#include "core/detail/byte_planes.hpp"
#include "core/detail/hdf5_detail.hpp"
#include "core/hdf5.hpp"

namespace carillon::core {

using namespace hdf5;

namespace {

/// Rows of a chunk.
std::uint64_t chunk_rows(const Extent& extent, const StorageOptions& storage,
                         std::size_t element_size) {
  // HDF5 takes no chunk of 4 GiB or more; compressed it may be somewhat longer.
  constexpr std::uint64_t largest_chunk = std::numeric_limits<std::int32_t>::max();
  const std::uint64_t row_bytes = product(extent, 1) * element_size;
  const std::uint64_t fitting = std::max<std::uint64_t>(1, largest_chunk / row_bytes);
  return std::min({storage.chunk_rows, extent[0], fitting});
}

/// Chunks of whole rows; without chunks the array lies in one piece.
void set_storage(hid_t properties, const std::string& file, const std::string& name,
                 const Extent& extent, const StorageOptions& storage, std::size_t element_size) {
  if (storage.deflate < 0 || storage.deflate > 9) {
    refuse(file, name, fmt::format("deflate is 0 to 9, not {}", storage.deflate));
  }
  if (storage.chunk_rows == 0 && storage.deflate > 0) {
    refuse(file, name, "compression needs chunks (chunk_rows)");
  }
  if (storage.chunk_rows == 0 || extent.empty() || product(extent) == 0) return;
  auto chunk = sizes(extent);
  chunk[0] = chunk_rows(extent, storage, element_size);
  check(H5Pset_chunk(properties, static_cast<int>(chunk.size()), chunk.data()), file, name,
        "cannot be chunked");
  if (storage.deflate == 0) return;
  // Bytes of equal weight side by side compress better.
  check(H5Pset_shuffle(properties), file, name, "cannot be compressed");
  check(H5Pset_deflate(properties, static_cast<unsigned>(storage.deflate)), file, name,
        "cannot be compressed");
}

template <class T>
Hdf5Object make_dataset(hid_t group, const std::string& file, const std::string& name,
                        const Extent& extent, const StorageOptions& storage, bool filled_later) {
  const Hdf5Object type = stored_type<T>();
  const Hdf5Object space = dataspace(extent);
  make_groups_above(group, file, name);
  const Hdf5Object links = link_properties();
  const Hdf5Object properties = untimed_properties(H5P_DATASET_CREATE);
  set_storage(properties.get(), file, name, extent, storage, H5Tget_size(type.get()));
  if (filled_later) H5Pset_fill_time(properties.get(), H5D_FILL_TIME_ALLOC);
  return checked(H5Dcreate2(group, name.c_str(), type.get(), space.get(), links.get(),
                            properties.get(), H5P_DEFAULT),
                 H5Dclose, file, name, "cannot be made");
}

/// Writes to the chosen part of a dataset.
template <class T>
void write_values(hid_t dataset, hid_t memory_space, hid_t file_space, const std::string& file,
                  const std::string& name, std::span<const T> values) {
  if (values.empty()) return;
  const Hdf5Object type = memory_type<T>();
  if constexpr (std::is_same_v<T, std::string>) {
    std::vector<const char*> pointers;
    for (const std::string& text : values) {
      if (text.find('\0') != std::string::npos) refuse(file, name, "a text with a zero byte");
      pointers.push_back(text.c_str());
    }
    check(H5Dwrite(dataset, type.get(), memory_space, file_space, H5P_DEFAULT, pointers.data()),
          file, name, "cannot be written");
  } else {
    check(H5Dwrite(dataset, type.get(), memory_space, file_space, H5P_DEFAULT, values.data()), file,
          name, "cannot be written");
  }
}

/// Deflates the chunks of a dataset here, with less work than HDF5's own filter and to the same
/// effect for who reads them. Chunks that do not shrink are left shuffled alone.
template <class T>
void write_chunks(hid_t dataset, const std::string& file, const std::string& name,
                  std::span<const T> values, const Extent& extent, const StorageOptions& storage) {
  const std::uint64_t row = product(extent, 1);
  const std::uint64_t rows = chunk_rows(extent, storage, sizeof(T));
  constexpr std::uint32_t without_deflate = 2;  // the second filter
  for (std::uint64_t first = 0; first < extent[0]; first += rows) {
    const auto given = values.subspan(first * row, std::min(rows, extent[0] - first) * row);
    // The last chunk is as long as the others.
    std::vector<T> chunk(given.begin(), given.end());
    chunk.resize(rows * row);
    const std::vector<unsigned char> planes = byte_planes(
        {reinterpret_cast<const unsigned char*>(chunk.data()),  // NOLINT: bytes of numbers
         chunk.size() * sizeof(T)},
        sizeof(T));
    const std::vector<unsigned char> deflated = deflate_planes(planes, sizeof(T), storage.deflate);
    const bool shrinks = deflated.size() < planes.size();
    const std::vector<unsigned char>& kept = shrinks ? deflated : planes;
    std::vector<hsize_t> place(extent.size(), 0);
    place[0] = first;
    check(H5Dwrite_chunk(dataset, H5P_DEFAULT, shrinks ? 0 : without_deflate, place.data(),
                         kept.size(), kept.data()),
          file, name, "cannot be written");
  }
}

/// In the name of a virtual source, HDF5 takes % for the start of a pattern.
std::string without_patterns(const std::string& name) {
  std::string plain;
  for (char c : name) plain.append(c == '%' ? 2 : 1, c);
  return plain;
}

/// Rows whose file is lost are read as no numbers by who asks HDF5 alone; as full scale where 16
/// bits have none.
void set_fill_value(hid_t properties, hid_t type) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::int16_t full_scale = std::numeric_limits<std::int16_t>::min();
  if (H5Tget_class(type) == H5T_FLOAT) {
    H5Pset_fill_value(properties, H5T_NATIVE_DOUBLE, &nan);
  } else if (H5Tequal(type, H5T_STD_I16LE) > 0) {
    H5Pset_fill_value(properties, H5T_NATIVE_INT16, &full_scale);
  }
}

}  // namespace

template <class T>
void Hdf5Group::write(const std::string& name, std::span<const T> values, const Extent& extent,
                      const StorageOptions& storage) const {
  const QuietErrors quiet;
  if (product(extent) != values.size()) {
    refuse(file_, name,
           fmt::format("{} values do not fill an array of {}", values.size(), shape_text(extent)));
  }
  const Hdf5Object dataset = make_dataset<T>(id_.get(), file_, name, extent, storage, false);
  // Elements lie in the file as they lie in memory.
  if constexpr (std::is_arithmetic_v<T> && std::endian::native == std::endian::little) {
    if (storage.deflate > 0 && !values.empty() && !extent.empty())
      return write_chunks(dataset.get(), file_, name, values, extent, storage);
  }
  write_values(dataset.get(), H5S_ALL, H5S_ALL, file_, name, values);
}

template <class T>
void Hdf5Group::create(const std::string& name, const Extent& extent,
                       const StorageOptions& storage) const {
  const QuietErrors quiet;
  make_dataset<T>(id_.get(), file_, name, extent, storage, true);
}

template <class T>
void Hdf5Group::write_rows(const std::string& name, std::uint64_t first,
                           std::span<const T> values) const {
  const QuietErrors quiet;
  const OpenDataset dataset = open_dataset(id_.get(), file_, name);
  const std::uint64_t row = product(dataset.extent, 1);
  const std::uint64_t count = row > 0 ? values.size() / row : 0;
  if (dataset.extent.empty() || count * row != values.size() || first > dataset.extent[0] ||
      count > dataset.extent[0] - first) {
    refuse(file_, name,
           fmt::format("{} values from row {} on do not fit an array of {}", values.size(), first,
                       shape_text(dataset.extent)));
  }
  if (values.empty()) return;
  const Hdf5Object space = dataspace(dataset.extent);
  select_rows(space.get(), dataset.extent, first, count);
  const Hdf5Object memory = dataspace({values.size()});
  write_values(dataset.id.get(), memory.get(), space.get(), file_, name, values);
}

void Hdf5Group::write_virtual(const std::string& name, const std::filesystem::path& folder,
                              std::span<const VirtualSource> sources) const {
  if (sources.empty()) refuse(file_, name, "a virtual dataset needs a source");
  const std::filesystem::path first_path = folder / sources[0].file;
  const Hdf5Group first_file = open_file(first_path);
  const QuietErrors quiet;
  const OpenDataset first =
      open_dataset(first_file.id_.get(), first_path.string(), sources[0].dataset);
  if (first.extent.empty()) refuse(first_path.string(), sources[0].dataset, "has no rows");

  Extent joined = first.extent;
  joined[0] = 0;
  for (const VirtualSource& source : sources) joined[0] += source.rows;
  const Hdf5Object properties = untimed_properties(H5P_DATASET_CREATE);
  const Hdf5Object space = dataspace(joined);
  std::uint64_t row = 0;
  for (const VirtualSource& source : sources) {
    if (source.rows == 0) continue;
    Extent extent = first.extent;
    extent[0] = source.rows;
    const Hdf5Object source_space = dataspace(extent);
    select_rows(space.get(), joined, row, source.rows);
    row += source.rows;
    check(H5Pset_virtual(properties.get(), space.get(), without_patterns(source.file).c_str(),
                         without_patterns(source.dataset).c_str(), source_space.get()),
          file_, name, "cannot be joined");
  }
  H5Sselect_all(space.get());
  set_fill_value(properties.get(), first.type.get());
  make_groups_above(id_.get(), file_, name);
  const Hdf5Object links = link_properties();
  checked(H5Dcreate2(id_.get(), name.c_str(), first.type.get(), space.get(), links.get(),
                     properties.get(), H5P_DEFAULT),
          H5Dclose, file_, name, "cannot be made");
}

#define CARILLON_HDF5_ELEMENT(T)                                                                \
  template void Hdf5Group::write<T>(const std::string&, std::span<const T>, const Extent&,      \
                                    const StorageOptions&) const;                               \
  template void Hdf5Group::create<T>(const std::string&, const Extent&, const StorageOptions&)  \
      const;                                                                                    \
  template void Hdf5Group::write_rows<T>(const std::string&, std::uint64_t, std::span<const T>) \
      const
CARILLON_FOR_EACH_ELEMENT(CARILLON_HDF5_ELEMENT);
#undef CARILLON_HDF5_ELEMENT

}  // namespace carillon::core
