#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/detail/hdf5_detail.hpp"
#include "core/hdf5.hpp"

namespace carillon::core {

namespace hdf5 {

std::uint64_t product(const Extent& extent, std::size_t first_axis) {
  std::uint64_t count = 1;
  for (std::size_t axis = first_axis; axis < extent.size(); ++axis) count *= extent[axis];
  return count;
}

std::string shape_text(const Extent& extent) {
  return fmt::format("[{}]", fmt::join(extent, ", "));
}

std::vector<hsize_t> sizes(const Extent& extent) {
  return {extent.begin(), extent.end()};
}

Hdf5Object dataspace(const Extent& extent) {
  if (extent.empty()) return Hdf5Object(H5Screate(H5S_SCALAR), H5Sclose);
  const auto size = sizes(extent);
  return Hdf5Object(H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr),
                    H5Sclose);
}

void select_rows(hid_t space, const Extent& extent, std::uint64_t first, std::uint64_t count) {
  std::vector<hsize_t> start(extent.size(), 0);
  auto size = sizes(extent);
  start[0] = first;
  size[0] = count;
  H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, size.data(), nullptr);
}

OpenDataset open_dataset(hid_t group, const std::string& file, const std::string& name,
                         hid_t access) {
  OpenDataset dataset;
  dataset.id =
      checked(H5Dopen2(group, name.c_str(), access), H5Dclose, file, name, "cannot be opened");
  dataset.type = Hdf5Object(H5Dget_type(dataset.id.get()), H5Tclose);
  const Hdf5Object space(H5Dget_space(dataset.id.get()), H5Sclose);
  const int rank = H5Sget_simple_extent_ndims(space.get());
  if (rank < 0) fail(file, name, "has no extent");
  std::vector<hsize_t> size(static_cast<std::size_t>(rank));
  H5Sget_simple_extent_dims(space.get(), size.data(), nullptr);
  dataset.extent.assign(size.begin(), size.end());
  return dataset;
}

namespace {

Hdf5Object dataset_object(hid_t group, const std::string& file, const std::string& name) {
  return checked(H5Dopen2(group, name.c_str(), H5P_DEFAULT), H5Dclose, file, name,
                 "cannot be opened");
}

/// A name that `get(buffer, size)` hands out, as HDF5's functions do.
template <class Get>
std::string name_from(const Get& get) {
  const ssize_t length = get(nullptr, 0);
  if (length < 0) return "";
  std::string name(static_cast<std::size_t>(length) + 1, '\0');
  get(name.data(), name.size());
  name.pop_back();
  return name;
}

/// In the name of a virtual source, HDF5 writes % twice.
std::string with_single_percents(const std::string& name) {
  std::string plain;
  for (std::size_t i = 0; i < name.size(); ++i) {
    plain += name[i];
    if (name[i] == '%' && i + 1 < name.size() && name[i + 1] == '%') ++i;
  }
  return plain;
}

}  // namespace

std::vector<VirtualSource> virtual_sources(hid_t dataset, const std::string& file,
                                           const std::string& name) {
  const Hdf5Object properties(H5Dget_create_plist(dataset), H5Pclose);
  std::vector<VirtualSource> sources;
  if (H5Pget_layout(properties.get()) != H5D_VIRTUAL) return sources;
  std::size_t count = 0;
  check(H5Pget_virtual_count(properties.get(), &count), file, name, "cannot be resolved");
  for (std::size_t i = 0; i < count; ++i) {
    VirtualSource source;
    source.file = with_single_percents(name_from([&](char* text, std::size_t size) {
      return H5Pget_virtual_filename(properties.get(), i, text, size);
    }));
    source.dataset = with_single_percents(name_from([&](char* text, std::size_t size) {
      return H5Pget_virtual_dsetname(properties.get(), i, text, size);
    }));
    // Where the block lies here: the extent of the source itself is not kept.
    const Hdf5Object space(H5Pget_virtual_vspace(properties.get(), i), H5Sclose);
    hsize_t begin[H5S_MAX_RANK] = {}, end[H5S_MAX_RANK] = {};
    const bool chosen = H5Sget_select_bounds(space.get(), begin, end) >= 0;
    source.rows = chosen ? end[0] - begin[0] + 1 : 0;
    sources.push_back(std::move(source));
  }
  return sources;
}

}  // namespace hdf5

using namespace hdf5;

std::string Hdf5Group::element_type(const std::string& name) const {
  const QuietErrors quiet;
  const Hdf5Object dataset = dataset_object(id_.get(), file_, name);
  const Hdf5Object type(H5Dget_type(dataset.get()), H5Tclose);
  const std::size_t bits = 8 * H5Tget_size(type.get());
  switch (H5Tget_class(type.get())) {
    case H5T_STRING:
      return "text";
    case H5T_FLOAT:
      return bits == 32 || bits == 64 ? fmt::format("float{}", bits) : "other";
    case H5T_INTEGER:
      return fmt::format("{}int{}", H5Tget_sign(type.get()) == H5T_SGN_NONE ? "u" : "", bits);
    default:
      return "other";
  }
}

std::vector<VirtualSource> Hdf5Group::virtual_sources(const std::string& name) const {
  const QuietErrors quiet;
  return hdf5::virtual_sources(dataset_object(id_.get(), file_, name).get(), file_, name);
}

Extent Hdf5Group::extent(const std::string& name) const {
  const QuietErrors quiet;
  return open_dataset(id_.get(), file_, name).extent;
}

bool Hdf5Group::is_text(const std::string& name) const {
  const QuietErrors quiet;
  return H5Tget_class(open_dataset(id_.get(), file_, name).type.get()) == H5T_STRING;
}

}  // namespace carillon::core
