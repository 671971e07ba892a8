#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstring>
#include <fstream>
#include <limits>
#include <map>

#include "core/error.hpp"
#include "core/npy.hpp"

namespace carillon::core {

namespace {

/// More than any header of numbers takes; those of format 1.0 cannot be longer.
constexpr std::size_t longest_header = 65546;

struct Element {
  std::size_t size;
  double (*value)(const char* bytes);
};

template <class T>
double value_of(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<double>(value);
}

template <class T>
constexpr Element element = {sizeof(T), value_of<T>};

const Element& element_of(const std::string& type) {
  static const std::map<std::string, Element> elements = {
      {"float32", element<float>},      {"float64", element<double>},
      {"int8", element<std::int8_t>},   {"uint8", element<std::uint8_t>},
      {"int16", element<std::int16_t>}, {"uint16", element<std::uint16_t>},
      {"int32", element<std::int32_t>}, {"uint32", element<std::uint32_t>},
      {"int64", element<std::int64_t>}, {"uint64", element<std::uint64_t>}};
  return elements.at(type);
}

/// a b, or nothing where that is no number of bytes.
std::uint64_t product(std::uint64_t a, std::uint64_t b) {
  if (b != 0 && a > std::numeric_limits<std::uint64_t>::max() / b) {
    throw InputError("the array's extent is beyond any file", "write it again with numpy.save");
  }
  return a * b;
}

std::string beginning_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes(longest_header, '\0');
  if (!file || std::filesystem::is_directory(path)) {
    throw FileError(fmt::format("{}: cannot be read", path.string()));
  }
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(file.gcount()));
  return bytes;
}

}  // namespace

NpyFile::NpyFile(std::filesystem::path path) : path_(std::move(path)) {
  const std::string beginning = beginning_of(path_);
  try {
    header_ = parse_npy_header(beginning, offset_);
    for (std::size_t axis = 1; axis < header_.extent.size(); ++axis) {
      row_size_ = product(row_size_, header_.extent[axis]);
    }
    const std::uint64_t needed = product(product(rows(), row_size_), element_of(type()).size);
    const std::uint64_t there = std::filesystem::file_size(path_) - offset_;
    if (there < needed) {
      throw InputError(fmt::format("{} bytes of elements, where {} of type {} take {}", there,
                                   fmt::join(header_.extent, " x "), type(), needed),
                       "the file is not whole: copy or unpack it again");
    }
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", path_.string(), error.message()), error.hint());
  }
}

std::vector<double> NpyFile::read_rows(std::uint64_t first, std::uint64_t count) const {
  if (first > rows() || count > rows() - first) {
    throw InputError(
        fmt::format("{}: rows {} to {} of {}", path_.string(), first, first + count, rows()));
  }
  const Element& element = element_of(type());
  const std::uint64_t row_bytes = row_size_ * element.size;
  std::string bytes(count * row_bytes, '\0');
  std::ifstream file(path_, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(offset_ + first * row_bytes));
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!file) throw FileError(fmt::format("{}: cannot be read", path_.string()));
  std::vector<double> values(count * row_size_);
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = element.value(bytes.data() + i * element.size);
  }
  return values;
}

}  // namespace carillon::core
