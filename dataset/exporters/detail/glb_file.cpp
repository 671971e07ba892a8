#include "dataset/exporters/detail/glb_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <limits>

#include "core/error.hpp"

namespace carillon::dataset::exporters {

static_assert(std::endian::native == std::endian::little, "glTF is little-endian");

namespace {

constexpr int float_type = 5126, unsigned_type = 5125;
constexpr int no_target = 0, vertex_target = 34962, index_target = 34963;

void append(std::string& text, std::uint32_t number) {
  text.append(reinterpret_cast<const char*>(&number), sizeof number);
}

}  // namespace

std::size_t GlbFile::add(std::span<const std::byte> bytes, int component_type, const char* type,
                         std::size_t count, int target) {
  // Every component here has four bytes, so that all views begin where they may.
  nlohmann::ordered_json view = {
      {"buffer", 0}, {"byteOffset", buffer_.size()}, {"byteLength", bytes.size()}};
  if (target != no_target) view["target"] = target;
  accessors_.push_back({{"bufferView", views_.size()},
                        {"componentType", component_type},
                        {"count", count},
                        {"type", type}});
  views_.push_back(std::move(view));
  buffer_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return accessors_.size() - 1;
}

std::size_t GlbFile::add_vertices(std::span<const std::array<float, 3>> values, bool with_range) {
  const std::size_t number =
      add(std::as_bytes(values), float_type, "VEC3", values.size(), vertex_target);
  if (!with_range) return number;
  std::array<float, 3> low = values.front(), high = low;
  for (const auto& value : values) {
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], value[k]);
      high[k] = std::max(high[k], value[k]);
    }
  }
  accessors_[number]["min"] = low;
  accessors_[number]["max"] = high;
  return number;
}

std::size_t GlbFile::add_indices(std::span<const std::uint32_t> values) {
  return add(std::as_bytes(values), unsigned_type, "SCALAR", values.size(), index_target);
}

std::size_t GlbFile::add_times(std::span<const float> values) {
  const std::size_t number = add_numbers(values);
  accessors_[number]["min"] = {values.front()};
  accessors_[number]["max"] = {values.back()};
  return number;
}

std::size_t GlbFile::add_numbers(std::span<const float> values) {
  return add(std::as_bytes(values), float_type, "SCALAR", values.size(), no_target);
}

std::size_t GlbFile::add_vectors(std::span<const std::array<float, 3>> values) {
  return add(std::as_bytes(values), float_type, "VEC3", values.size(), no_target);
}

std::size_t GlbFile::add_whole_numbers(std::span<const std::uint32_t> values) {
  return add(std::as_bytes(values), unsigned_type, "SCALAR", values.size(), no_target);
}

std::string GlbFile::bytes() const {
  nlohmann::ordered_json whole = document;
  whole["accessors"] = accessors_;
  whole["bufferViews"] = views_;
  whole["buffers"] = {{{"byteLength", buffer_.size()}}};
  std::string json = whole.dump();
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::string binary = buffer_;
  binary.resize((binary.size() + 3) / 4 * 4, '\0');

  constexpr std::uint32_t magic = 0x46546C67, version = 2;  // "glTF"
  constexpr std::uint32_t json_chunk = 0x4E4F534A, binary_chunk = 0x004E4942;
  constexpr std::size_t heads = 12 + 8 + 8;
  const std::size_t length = heads + json.size() + binary.size();
  if (length > std::numeric_limits<std::uint32_t>::max()) {
    throw core::InputError(
        fmt::format("a GLB file of {} bytes cannot be: 4 GiB is the most", length),
        "fewer modes, or a larger --element-size");
  }
  std::string file;
  for (const std::uint32_t number : {magic, version, static_cast<std::uint32_t>(length),
                                     static_cast<std::uint32_t>(json.size()), json_chunk}) {
    append(file, number);
  }
  file += json;
  append(file, static_cast<std::uint32_t>(binary.size()));
  append(file, binary_chunk);
  return file + binary;
}

}  // namespace carillon::dataset::exporters
