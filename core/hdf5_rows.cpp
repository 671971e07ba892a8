#include "core/hdf5_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <numeric>
#include <optional>
#include <stdexcept>

#include "core/detail/chunk_reader.hpp"
#include "core/detail/hdf5_detail.hpp"
#include "core/error.hpp"

namespace carillon::core {

using namespace hdf5;

namespace {

/// Files of a virtual dataset that HDF5 keeps open.
constexpr std::size_t max_open_files = 128;

/// Some rows of a virtual dataset, which another file holds.
struct Part {
  VirtualSource source;
  std::uint64_t begin = 0;           ///< first row of the whole
  std::optional<Hdf5Rows> opened{};  ///< once it was read
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

}  // namespace

struct Hdf5Rows::Array {
  std::string file, name;
  Extent extent;
  std::optional<OpenDataset> dataset;  ///< none while HDF5 has the file closed
  ChunkReader chunks;
  std::vector<Part> parts{};              ///< of a virtual dataset, in order of their rows
  std::vector<std::size_t> open_parts{};  ///< whose files HDF5 has open
  std::uint64_t reads = 0;
  ChunkReader::Scratch scratch{};  ///< of all parts

  /// Closes the file; what is known of its chunks stays.
  /// @return false where they cannot be read so
  bool close() {
    if (dataset) chunks.locate(*dataset);
    chunks.close();
    if (chunks.is_complete()) dataset.reset();
    return chunks.is_complete();
  }

  /// The part that holds a row, known to HDF5 or by its chunks.
  Part& part_of(std::uint64_t row) {
    const auto after =
        std::upper_bound(parts.begin(), parts.end(), row,
                         [](std::uint64_t value, const Part& part) { return value < part.begin; });
    if (after == parts.begin() || row - std::prev(after)->begin >= std::prev(after)->source.rows) {
      refuse(file, name, fmt::format("row {} lies in none of the files that are joined", row));
    }
    Part& part = *std::prev(after);
    if (!part.opened) open(part);
    part.used = ++reads;
    return part;
  }

  void open(Part& part) {
    if (open_parts.size() >= max_open_files) {
      const auto oldest = std::min_element(
          open_parts.begin(), open_parts.end(),
          [&](std::size_t a, std::size_t b) { return parts[a].used < parts[b].used; });
      std::optional<Hdf5Rows>& closed = parts[*oldest].opened;
      if (closed && !closed->array_->close()) closed.reset();
      open_parts.erase(oldest);
    }
    const auto lost = [&](const std::string& what) {
      throw FileError(what,
                      fmt::format("{} has rows {} to {} of {} from there; carillon check lists "
                                  "what is missing, and the same build makes it again",
                                  file, part.begin, part.begin + part.source.rows - 1, name));
    };
    const std::filesystem::path path = std::filesystem::path(file).parent_path() / part.source.file;
    std::optional<Hdf5Rows> opened;
    try {
      opened.emplace(Hdf5Group::open_file(path), part.source.dataset);
    } catch (const FileError& error) {
      lost(error.message());
    }
    Extent expected = extent;
    expected[0] = part.source.rows;
    if (opened->extent() != expected) {
      lost(fmt::format("{}: {}: an array of {} where {} was joined", path.string(),
                       part.source.dataset, shape_text(opened->extent()), shape_text(expected)));
    }
    part.opened = std::move(opened);
    open_parts.push_back(static_cast<std::size_t>(&part - parts.data()));
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

  /// @return false where HDF5 must open the file for it
  template <class T>
  bool read_block(std::uint64_t first, std::uint64_t count, T* values,
                  ChunkReader::Scratch& buffers) {
    if constexpr (!std::is_same_v<T, std::string>) {
      const Hdf5Object type = memory_type<T>();
      const std::uint64_t width = product(extent, 1);
      if (dataset && count > 0) chunks.locate(*dataset);
      while (count > 0 && chunks.is_complete()) {
        const std::uint64_t some = std::min(count, chunks.rows() - first % chunks.rows());
        if (!chunks.read(type.get(), first, some, values, buffers)) break;
        first += some;
        count -= some;
        values += some * width;
      }
    }
    if (count == 0) return true;
    if (!dataset) return false;
    read_own(*dataset, file, name, first, count, values);
    return true;
  }

  /// @return false where HDF5 must open the file for it
  template <class T>
  bool read(std::span<const std::uint64_t> rows, T* values, ChunkReader::Scratch& buffers) {
    const std::uint64_t width = product(extent, 1);
    std::vector<T> between;
    for (std::size_t i = 0; i < rows.size();) {
      const auto some = rows.subspan(i, together(rows.subspan(i)));
      const std::uint64_t count = some.back() - some.front() + 1;
      T* const to = values + i * width;
      if (count == some.size()) {
        if (!read_block(some.front(), count, to, buffers)) return false;
      } else {
        between.resize(count * width);
        if (!read_block(some.front(), count, between.data(), buffers)) return false;
        for (std::size_t k = 0; k < some.size(); ++k) {
          std::move(between.begin() + (some[k] - some.front()) * width,
                    between.begin() + (some[k] - some.front() + 1) * width, to + k * width);
        }
      }
      i += some.size();
    }
    return true;
  }

  /// Rows of one part, counted from its own first.
  template <class T>
  void read_part(Part& part, std::span<const std::uint64_t> rows, T* values) {
    if (!part.opened->array_->read(rows, values, scratch)) {
      part.opened.reset();
      open(part);
      part.opened->array_->read(rows, values, scratch);
    }
    // Of a file that HDF5 has closed the descriptor is not kept either.
    if (!part.opened->array_->dataset) part.opened->array_->chunks.close();
  }
};

Hdf5Rows::Hdf5Rows(const Hdf5Group& group, const std::string& name) {
  const QuietErrors quiet;
  OpenDataset dataset = open_for_rows(group.id_.get(), group.file_, name);
  ChunkReader chunks(dataset, group.file_);
  array_ = std::make_unique<Array>(
      Array{group.file_, name, dataset.extent, std::move(dataset), std::move(chunks)});
  std::uint64_t begin = 0;
  for (VirtualSource& source : virtual_sources(array_->dataset->id.get(), group.file_, name)) {
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
  return array_->extent;
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
  if (array.parts.empty()) {
    array.read(rows, values.data(), array.scratch);
    return;
  }
  std::vector<std::uint64_t> within;
  for (std::size_t i = 0; i < rows.size(); i += within.size()) {
    Part& part = array.part_of(rows[i]);
    within.clear();
    for (const std::uint64_t row : rows.subspan(i)) {
      if (row < part.begin || row - part.begin >= part.source.rows) break;
      within.push_back(row - part.begin);
    }
    array.read_part(part, within, values.data() + i * width());
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
CARILLON_FOR_EACH_ELEMENT(CARILLON_HDF5_ELEMENT);
#undef CARILLON_HDF5_ELEMENT

}  // namespace carillon::core
