#include "dataset/exporters/detail/npy_rows.hpp"

#include <fmt/format.h>

#include <map>

#include "core/error.hpp"
#include "core/npy.hpp"

namespace carillon::dataset::exporters {

namespace {

template <class T>
std::string bytes_of(const core::Hdf5Group& group, const std::string& name, std::uint64_t row) {
  const std::vector<T> values = group.read_rows<T>(name, row, 1);
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// How rows are read, by the element types that datasets have.
const std::map<std::string, decltype(&bytes_of<float>)> readers = {
    {"float32", bytes_of<float>},        {"float64", bytes_of<double>},
    {"uint8", bytes_of<std::uint8_t>},   {"int16", bytes_of<std::int16_t>},
    {"int32", bytes_of<std::int32_t>},   {"int64", bytes_of<std::int64_t>},
    {"uint32", bytes_of<std::uint32_t>}, {"uint64", bytes_of<std::uint64_t>}};

}  // namespace

NpyRows::NpyRows(const core::Hdf5Group& group, const std::string& name)
    : group_(group), name_(name), type_(group.element_type(name)) {
  if (!readers.contains(type_)) {
    throw core::InputError(fmt::format("\"{}\" holds {}, which makes no array", name, type_),
                           "texts are in each sample's .json");
  }
  const core::Extent extent = group.extent(name);
  header_ = core::npy_header({type_, {extent.begin() + 1, extent.end()}});
}

std::string NpyRows::row(std::uint64_t row) const {
  return header_ + readers.at(type_)(group_, name_, row);
}

}  // namespace carillon::dataset::exporters
