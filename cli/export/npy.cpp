#include "cli/export/npy.hpp"

#include <fmt/format.h>

#include <map>

#include "core/error.hpp"

namespace carillon::cli {

namespace {

/// Of the element types that datasets have, NumPy's names; all little-endian.
const std::map<std::string, std::string> numpy_types = {
    {"float32", "<f4"}, {"float64", "<f8"}, {"uint8", "|u1"},  {"int16", "<i2"},
    {"int32", "<i4"},   {"int64", "<i8"},   {"uint32", "<u4"}, {"uint64", "<u8"}};

std::string header_of(const std::string& type, const core::Extent& extent) {
  std::string shape;
  for (std::size_t axis = 1; axis < extent.size(); ++axis)
    shape += fmt::format("{}, ", extent[axis]);
  std::string text = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}",
                                 numpy_types.at(type), shape);
  // Magic, version and length take 10 bytes; all of it a multiple of 64.
  constexpr std::size_t fixed = 10, multiple = 64;
  const std::size_t length = (fixed + text.size() + 1 + multiple - 1) / multiple * multiple - fixed;
  text.resize(length - 1, ' ');
  text += '\n';
  return std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(length & 0xff) +
         static_cast<char>(length >> 8) + text;
}

template <class T>
std::string bytes_of(const core::Hdf5Group& group, const std::string& name, std::uint64_t row) {
  const std::vector<T> values = group.read_rows<T>(name, row, 1);
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

}  // namespace

NpyRows::NpyRows(const core::Hdf5Group& group, const std::string& name)
    : group_(group), name_(name), type_(group.element_type(name)) {
  if (!numpy_types.contains(type_)) {
    throw core::InputError(fmt::format("\"{}\" holds {}, which makes no array", name, type_),
                           "texts are in each sample's .json");
  }
  header_ = header_of(type_, group.extent(name));
}

std::string NpyRows::row(std::uint64_t row) const {
  static const std::map<std::string, decltype(&bytes_of<float>)> readers = {
      {"float32", bytes_of<float>},        {"float64", bytes_of<double>},
      {"uint8", bytes_of<std::uint8_t>},   {"int16", bytes_of<std::int16_t>},
      {"int32", bytes_of<std::int32_t>},   {"int64", bytes_of<std::int64_t>},
      {"uint32", bytes_of<std::uint32_t>}, {"uint64", bytes_of<std::uint64_t>}};
  return header_ + readers.at(type_)(group_, name_, row);
}

}  // namespace carillon::cli
