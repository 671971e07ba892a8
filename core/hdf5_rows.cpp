#include "core/hdf5_rows.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <numeric>
#include <optional>
#include <stdexcept>

#include "core/detail/byte_planes.hpp"
#include "core/detail/hdf5_detail.hpp"
#include "core/error.hpp"

namespace carillon::core {

using namespace hdf5;

namespace {

/// Files of a virtual dataset that are kept open.
constexpr std::size_t max_open_files = 256;

/// Some rows of a virtual dataset, which another file holds.
struct Part {
  VirtualSource source;
  std::uint64_t begin = 0;           ///< first row of the whole
  std::optional<Hdf5Rows> opened{};  ///< while it is
  std::uint64_t used = 0;            ///< when it was read last
};

/// Opens an array to be read a row at a time. Chunks are not kept: caches of many files would fill
/// the memory, and rows in random order find nothing in them.
OpenDataset open_for_rows(hid_t group, const std::string& file, const std::string& name) {
  const Hdf5Object access(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose);
  H5Pset_chunk_cache(access.get(), 1, 0, 1);
  OpenDataset dataset = open_dataset(group, file, name, access.get());
  if (dataset.extent.empty()) refuse(file, name, "is a single value and has no rows");
  return dataset;
}

/// Rows [first, first + count), or the single value, of what a file holds itself.
template <class T>
void read_own(const OpenDataset& dataset, const std::string& file, const std::string& name,
              std::uint64_t first, std::uint64_t count, T* values) {
  const bool is_text = H5Tget_class(dataset.type.get()) == H5T_STRING;
  if (is_text != std::is_same_v<T, std::string>) {
    refuse(file, name, is_text ? "holds texts, not numbers" : "holds no texts");
  }
  const std::uint64_t size = count * product(dataset.extent, 1);
  if (size == 0) return;
  const Hdf5Object space = dataspace(dataset.extent), memory = dataspace({size});
  if (!dataset.extent.empty()) select_rows(space.get(), dataset.extent, first, count);
  const auto read = [&](hid_t type, void* buffer) {
    check(H5Dread(dataset.id.get(), type, memory.get(), space.get(), H5P_DEFAULT, buffer), file,
          name, "cannot be read");
  };
  if constexpr (std::is_same_v<T, std::string>) {
    std::vector<std::string> texts = read_texts(dataset.type.get(), memory.get(), size, read);
    std::move(texts.begin(), texts.end(), values);
  } else {
    read(memory_type<T>().get(), values);
  }
}

/// Chunks that were written as core/hdf5_arrays.cpp does it, read without HDF5's own way, which
/// takes ten times as long for a row: where they lie is asked of it once.
class OwnChunks {
 public:
  explicit OwnChunks(const OpenDataset& dataset) {
    const Hdf5Object properties(H5Dget_create_plist(dataset.id.get()), H5Pclose);
    if (H5Pget_layout(properties.get()) != H5D_CHUNKED) return;
    std::vector<hsize_t> chunk(dataset.extent.size());
    H5Pget_chunk(properties.get(), static_cast<int>(chunk.size()), chunk.data());
    rows_ = chunk.front();
    element_size_ = H5Tget_size(dataset.type.get());
    const Hdf5Object native(H5Tget_native_type(dataset.type.get(), H5T_DIR_ASCEND), H5Tclose);
    const bool whole_rows = std::equal(chunk.begin() + 1, chunk.end(), dataset.extent.begin() + 1);
    if (!whole_rows || H5Tequal(native.get(), dataset.type.get()) <= 0 ||
        filter_of(properties.get(), 0) != H5Z_FILTER_SHUFFLE ||
        filter_of(properties.get(), 1) != H5Z_FILTER_DEFLATE ||
        H5Pget_nfilters(properties.get()) != 2) {
      return;
    }
    file_ = Hdf5Object(H5Iget_file_id(dataset.id.get()), H5Fclose);
    void* handle = nullptr;
    if (H5Fget_vfd_handle(file_.get(), H5P_DEFAULT, &handle) < 0 || handle == nullptr) return;
    const Hdf5Object access(H5Fget_access_plist(file_.get()), H5Pclose);
    if (H5Pget_driver(access.get()) != H5FD_SEC2) return;
    descriptor_ = *static_cast<int*>(handle);
    places_.resize((dataset.extent[0] + rows_ - 1) / rows_);
    planes_.resize(rows_ * product(dataset.extent, 1) * element_size_);
    values_.resize(planes_.size());
  }

  /// Rows that are decompressed together; 0: each lies by itself.
  std::uint64_t rows() const { return rows_; }

  /// Rows [first, first + count) of one chunk.
  /// @param type  the values' in memory
  /// @return false where HDF5 itself must read them
  bool read(const OpenDataset& dataset, hid_t type, std::uint64_t first, std::uint64_t count,
            void* to) {
    if (descriptor_ < 0 || H5Tequal(type, dataset.type.get()) <= 0) return false;
    const Place& place = place_of(dataset, first / rows_);
    if (place.bytes == 0 || !load(place)) return false;
    const std::size_t row = values_.size() / rows_;
    std::memcpy(to, values_.data() + first % rows_ * row, count * row);
    return true;
  }

 private:
  struct Place {
    haddr_t address = HADDR_UNDEF;
    hsize_t bytes = 0;  ///< 0: not asked for yet, or none
    unsigned skipped_filters = 0;
  };

  static H5Z_filter_t filter_of(hid_t properties, unsigned number) {
    unsigned flags = 0;
    std::size_t values = 0;
    return H5Pget_filter2(properties, number, &flags, &values, nullptr, 0, nullptr, nullptr);
  }

  const Place& place_of(const OpenDataset& dataset, std::uint64_t chunk) {
    Place& place = places_[chunk];
    if (place.bytes > 0) return place;
    std::vector<hsize_t> corner(dataset.extent.size(), 0);
    corner[0] = chunk * rows_;
    H5Dget_chunk_info_by_coord(dataset.id.get(), corner.data(), &place.skipped_filters,
                               &place.address, &place.bytes);
    return place;
  }

  /// @return false where it is damaged: HDF5 says how
  bool load(const Place& place) {
    constexpr unsigned shuffle = 1, deflate = 2;
    if ((place.skipped_filters & shuffle) != 0 || place.address == HADDR_UNDEF) return false;
    const bool is_deflated = (place.skipped_filters & deflate) == 0;
    std::vector<unsigned char>& read = is_deflated ? packed_ : planes_;
    if (is_deflated) packed_.resize(place.bytes);
    if (read.size() != place.bytes ||
        pread(descriptor_, read.data(), read.size(), static_cast<off_t>(place.address)) !=
            static_cast<ssize_t>(read.size()) ||
        (is_deflated && !inflate_planes(packed_, planes_))) {
      return false;
    }
    from_byte_planes(planes_, element_size_, values_);
    return true;
  }

  std::uint64_t rows_ = 0;
  std::size_t element_size_ = 0;
  Hdf5Object file_;  ///< whose descriptor it is
  int descriptor_ = -1;
  std::vector<Place> places_;
  std::vector<unsigned char> packed_, planes_, values_;
};

}  // namespace

struct Hdf5Rows::Array {
  std::string file, name;
  OpenDataset dataset;
  OwnChunks chunks;
  std::vector<Part> parts{};  ///< of a virtual dataset, in order of their rows
  std::vector<std::size_t> open_parts{};
  std::uint64_t reads = 0;

  /// The part that holds a row, opened.
  const Part& part_of(std::uint64_t row) {
    const auto after =
        std::upper_bound(parts.begin(), parts.end(), row,
                         [](std::uint64_t value, const Part& part) { return value < part.begin; });
    const std::size_t i = static_cast<std::size_t>(after - parts.begin()) - 1;
    if (after == parts.begin() || row - parts[i].begin >= parts[i].source.rows) {
      refuse(file, name, fmt::format("row {} lies in none of the files that are joined", row));
    }
    if (!parts[i].opened) open(i);
    parts[i].used = ++reads;
    return parts[i];
  }

  void open(std::size_t i) {
    if (open_parts.size() >= max_open_files) {
      const auto oldest = std::min_element(
          open_parts.begin(), open_parts.end(),
          [&](std::size_t a, std::size_t b) { return parts[a].used < parts[b].used; });
      parts[*oldest].opened.reset();
      open_parts.erase(oldest);
    }
    Part& part = parts[i];
    const auto lost = [&](const std::string& what) {
      throw FileError(what,
                      fmt::format("{} has rows {} to {} of {} from there; carillon check lists "
                                  "what is missing, and the same build makes it again",
                                  file, part.begin, part.begin + part.source.rows - 1, name));
    };
    const std::filesystem::path path = std::filesystem::path(file).parent_path() / part.source.file;
    try {
      part.opened.emplace(Hdf5Group::open_file(path), part.source.dataset);
    } catch (const FileError& error) {
      lost(error.message());
    }
    Extent expected = dataset.extent;
    expected[0] = part.source.rows;
    if (part.opened->extent() != expected) {
      lost(fmt::format("{}: {}: an array of {} where {} was joined", path.string(),
                       part.source.dataset, shape_text(part.opened->extent()),
                       shape_text(expected)));
    }
    open_parts.push_back(i);
  }

  /// How many of ascending rows are best read in one go with all between them: neighbours, and what
  /// is decompressed together.
  std::size_t together(std::span<const std::uint64_t> rows) const {
    std::size_t count = 1;
    while (count < rows.size() &&
           (rows[count] == rows[count - 1] + 1 ||
            (chunks.rows() > 1 && rows[count] > rows[count - 1] &&
             rows[count] / chunks.rows() == rows[count - 1] / chunks.rows()))) {
      ++count;
    }
    return count;
  }

  template <class T>
  void read_block(std::uint64_t first, std::uint64_t count, T* values) {
    if constexpr (!std::is_same_v<T, std::string>) {
      const Hdf5Object type = memory_type<T>();
      const std::uint64_t width = product(dataset.extent, 1);
      while (count > 0 && chunks.rows() > 0) {
        const std::uint64_t some = std::min(count, chunks.rows() - first % chunks.rows());
        if (!chunks.read(dataset, type.get(), first, some, values)) break;
        first += some;
        count -= some;
        values += some * width;
      }
    }
    read_own(dataset, file, name, first, count, values);
  }

  template <class T>
  void read(std::span<const std::uint64_t> rows, std::uint64_t width, T* values) {
    std::vector<T> between;
    for (std::size_t i = 0; i < rows.size();) {
      const auto some = rows.subspan(i, together(rows.subspan(i)));
      const std::uint64_t count = some.back() - some.front() + 1;
      T* const to = values + i * width;
      if (count == some.size()) {
        read_block(some.front(), count, to);
      } else {
        between.resize(count * width);
        read_block(some.front(), count, between.data());
        for (std::size_t k = 0; k < some.size(); ++k) {
          std::move(between.begin() + (some[k] - some.front()) * width,
                    between.begin() + (some[k] - some.front() + 1) * width, to + k * width);
        }
      }
      i += some.size();
    }
  }
};

Hdf5Rows::Hdf5Rows(const Hdf5Group& group, const std::string& name) {
  const QuietErrors quiet;
  OpenDataset dataset = open_for_rows(group.id_.get(), group.file_, name);
  OwnChunks chunks(dataset);
  array_ = std::make_unique<Array>(Array{group.file_, name, std::move(dataset), std::move(chunks)});
  std::uint64_t begin = 0;
  for (VirtualSource& source : virtual_sources(array_->dataset.id.get(), group.file_, name)) {
    const std::uint64_t rows = source.rows;
    array_->parts.push_back({std::move(source), begin});
    begin += rows;
  }
}

Hdf5Rows::Hdf5Rows(Hdf5Rows&&) noexcept = default;
Hdf5Rows& Hdf5Rows::operator=(Hdf5Rows&& other) noexcept {
  std::swap(array_, other.array_);
  return *this;
}
Hdf5Rows::~Hdf5Rows() {
  const QuietErrors quiet;
  array_.reset();
}

const Extent& Hdf5Rows::extent() const {
  return array_->dataset.extent;
}

void Hdf5Rows::require_files() const {
  const QuietErrors quiet;
  for (const Part& part : array_->parts) {
    if (part.source.rows > 0) array_->part_of(part.begin);
  }
}

std::uint64_t Hdf5Rows::width() const {
  return product(extent(), 1);
}

template <class T>
void Hdf5Rows::read(std::span<const std::uint64_t> rows, std::span<T> values) const {
  const QuietErrors quiet;
  Array& array = *array_;
  if (values.size() != rows.size() * width()) {
    throw std::logic_error("Hdf5Rows: a buffer of another size than the rows");
  }
  for (const std::uint64_t row : rows) {
    if (row >= extent()[0]) {
      refuse(array.file, array.name,
             fmt::format("row {} lies outside an array of {}", row, shape_text(extent())));
    }
  }
  if (array.parts.empty()) return array.read(rows, width(), values.data());
  std::vector<std::uint64_t> within;
  for (std::size_t i = 0; i < rows.size(); i += within.size()) {
    const Part& part = array.part_of(rows[i]);
    within.clear();
    for (const std::uint64_t row : rows.subspan(i)) {
      if (row < part.begin || row - part.begin >= part.source.rows) break;
      within.push_back(row - part.begin);
    }
    part.opened->array_->read<T>(within, width(), values.data() + i * width());
  }
}

template <class T>
std::vector<T> Hdf5Rows::read(std::uint64_t first, std::uint64_t count) const {
  if (first > extent()[0] || count > extent()[0] - first) {
    refuse(array_->file, array_->name,
           fmt::format("rows {} to {} lie outside an array of {}", first, first + count,
                       shape_text(extent())));
  }
  std::vector<std::uint64_t> rows(count);
  std::iota(rows.begin(), rows.end(), first);
  std::vector<T> values(count * width());
  read<T>(rows, values);
  return values;
}

template <class T>
std::vector<T> Hdf5Group::read(const std::string& name) const {
  const Extent whole = extent(name);
  if (!whole.empty()) return read_rows<T>(name, 0, whole[0]);
  const QuietErrors quiet;
  std::vector<T> value(1);
  read_own(open_dataset(id_.get(), file_, name), file_, name, 0, 1, value.data());
  return value;
}

template <class T>
std::vector<T> Hdf5Group::read_rows(const std::string& name, std::uint64_t first,
                                    std::uint64_t count) const {
  return Hdf5Rows(*this, name).read<T>(first, count);
}

#define CARILLON_HDF5_ELEMENT(T)                                                       \
  template void Hdf5Rows::read<T>(std::span<const std::uint64_t>, std::span<T>) const; \
  template std::vector<T> Hdf5Rows::read<T>(std::uint64_t, std::uint64_t) const;       \
  template std::vector<T> Hdf5Group::read<T>(const std::string&) const;                \
  template std::vector<T> Hdf5Group::read_rows<T>(const std::string&, std::uint64_t,   \
                                                  std::uint64_t) const
CARILLON_HDF5_ELEMENT(float);
CARILLON_HDF5_ELEMENT(double);
CARILLON_HDF5_ELEMENT(std::int8_t);
CARILLON_HDF5_ELEMENT(std::int16_t);
CARILLON_HDF5_ELEMENT(std::int32_t);
CARILLON_HDF5_ELEMENT(std::int64_t);
CARILLON_HDF5_ELEMENT(std::uint8_t);
CARILLON_HDF5_ELEMENT(std::uint16_t);
CARILLON_HDF5_ELEMENT(std::uint32_t);
CARILLON_HDF5_ELEMENT(std::uint64_t);
CARILLON_HDF5_ELEMENT(std::string);
#undef CARILLON_HDF5_ELEMENT

}  // namespace carillon::core
