#include "core/detail/chunk_reader.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

#include "core/detail/byte_planes.hpp"

namespace carillon::core::hdf5 {

namespace {

H5Z_filter_t filter_of(hid_t properties, unsigned number) {
  unsigned flags = 0;
  std::size_t values = 0;
  return H5Pget_filter2(properties, number, &flags, &values, nullptr, 0, nullptr, nullptr);
}

bool is_same(const struct stat& one, const struct stat& other) {
  return one.st_dev == other.st_dev && one.st_ino == other.st_ino && one.st_size == other.st_size &&
         one.st_mtim.tv_sec == other.st_mtim.tv_sec && one.st_mtim.tv_nsec == other.st_mtim.tv_nsec;
}

}  // namespace

int ChunkReader::close_descriptor(int* descriptor) {
  return ::close(*descriptor);
}

ChunkReader::ChunkReader(const OpenDataset& dataset, std::string path) : path_(std::move(path)) {
  const Hdf5Object properties(H5Dget_create_plist(dataset.id.get()), H5Pclose);
  if (H5Pget_layout(properties.get()) != H5D_CHUNKED) return;
  std::vector<hsize_t> chunk(dataset.extent.size());
  H5Pget_chunk(properties.get(), static_cast<int>(chunk.size()), chunk.data());
  rows_ = chunk.front();
  Hdf5Object native(H5Tget_native_type(dataset.type.get(), H5T_DIR_ASCEND), H5Tclose);
  const bool whole_rows = std::equal(chunk.begin() + 1, chunk.end(), dataset.extent.begin() + 1);
  const bool is_own = whole_rows && H5Tequal(native.get(), dataset.type.get()) > 0 &&
                      H5Pget_nfilters(properties.get()) == 2 &&
                      filter_of(properties.get(), 0) == H5Z_FILTER_SHUFFLE &&
                      filter_of(properties.get(), 1) == H5Z_FILTER_DEFLATE;
  if (!is_own) return;
  element_size_ = H5Tget_size(native.get());
  row_bytes_ = product(dataset.extent, 1) * element_size_;
  type_ = std::move(native);
}

void ChunkReader::locate(const OpenDataset& dataset) {
  constexpr unsigned shuffle = 1;
  if (located_ || type_.get() < 0) return;
  located_ = true;
  if (stat(path_.c_str(), &file_) != 0) return;
  std::vector<hsize_t> corner(dataset.extent.size(), 0);
  complete_ = true;
  for (; corner[0] < dataset.extent[0]; corner[0] += rows_) {
    Place place;
    H5Dget_chunk_info_by_coord(dataset.id.get(), corner.data(), &place.skipped_filters,
                               &place.address, &place.bytes);
    complete_ = complete_ && place.bytes > 0 && place.address != HADDR_UNDEF &&
                (place.skipped_filters & shuffle) == 0;
    places_.push_back(place);
  }
}

bool ChunkReader::read(hid_t type, std::uint64_t first, std::uint64_t count, void* to,
                       Scratch& scratch) {
  if (!complete_ || H5Tequal(type, type_.get()) <= 0) return false;
  if (!load(places_[first / rows_], scratch)) return false;
  std::memcpy(to, scratch.values.data() + first % rows_ * row_bytes_, count * row_bytes_);
  return true;
}

bool ChunkReader::open() {
  if (descriptor_.get() >= 0) return true;
  Descriptor opened(::open(path_.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat now = {};
  if (opened.get() < 0 || fstat(opened.get(), &now) != 0 || !is_same(now, file_)) return false;
  descriptor_ = std::move(opened);
  return true;
}

bool ChunkReader::load(const Place& place, Scratch& scratch) {
  constexpr unsigned deflate = 2;
  const bool is_deflated = (place.skipped_filters & deflate) == 0;
  scratch.planes.resize(rows_ * row_bytes_);
  scratch.values.resize(scratch.planes.size());
  std::vector<unsigned char>& read = is_deflated ? scratch.packed : scratch.planes;
  if (is_deflated) read.resize(place.bytes);
  if (read.size() != place.bytes) return false;
  if (!open() ||
      pread(descriptor_.get(), read.data(), read.size(), static_cast<off_t>(place.address)) !=
          static_cast<ssize_t>(read.size()) ||
      (is_deflated && !inflate_planes(scratch.packed, scratch.planes))) {
    return false;
  }
  from_byte_planes(scratch.planes, element_size_, scratch.values);
  return true;
}

}  // namespace carillon::core::hdf5
