#include "scene/detail/gltf_reader.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <string_view>

#include "core/base64.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "solvers/mesh/readers/file_kind.hpp"

namespace carillon::scene {

namespace {

using nlohmann::json;

std::uint32_t word_at(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  if (at + sizeof word <= bytes.size()) std::memcpy(&word, bytes.data() + at, sizeof word);
  return word;
}

std::size_t component_size(int type) {
  switch (type) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    case 5125:
    case 5126:
      return 4;
    default:
      return 0;
  }
}

template <class T>
double value_as(const char* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return static_cast<double>(value);
}

double component(const char* at, int type) {
  switch (type) {
    case 5120:
      return value_as<std::int8_t>(at);
    case 5121:
      return value_as<std::uint8_t>(at);
    case 5122:
      return value_as<std::int16_t>(at);
    case 5123:
      return value_as<std::uint16_t>(at);
    case 5125:
      return value_as<std::uint32_t>(at);
    default:
      return value_as<float>(at);
  }
}

}  // namespace

GltfReader::GltfReader(const std::string& path) : path_(path) {
  const std::string bytes = core::read_file(path);
  std::string text = bytes, binary;
  constexpr std::size_t head = 12, chunk_head = 8;
  if (bytes.starts_with("glTF")) {
    const std::size_t size = word_at(bytes, head);
    if (bytes.size() < head + chunk_head + size) fail("the file is cut off");
    text = bytes.substr(head + chunk_head, size);
    const std::size_t next = head + chunk_head + size;
    if (next + chunk_head <= bytes.size())
      binary = bytes.substr(next + chunk_head, word_at(bytes, next));
  }
  document_ = json::parse(text, nullptr, false);
  if (!document_.is_object()) fail("no glTF: its JSON cannot be read");
  const json buffers = document_.value("buffers", json::array());
  if (!buffers.is_array()) fail("its buffers are no list");
  for (const json& buffer : buffers) {
    const std::string uri = buffer.is_object() ? buffer.value("uri", "") : "";
    if (uri.empty()) {
      buffers_.push_back(binary);
    } else if (uri.starts_with("data:")) {
      buffers_.push_back(core::from_base64(uri.substr(std::min(uri.find(',') + 1, uri.size()))));
    } else {
      const auto folder = std::filesystem::path(path).parent_path();
      buffers_.push_back(core::read_file(folder / solvers::mesh::readers::decoded_uri(uri)));
    }
  }
}

void GltfReader::fail(const std::string& what) const {
  throw core::InputError(fmt::format("{}: {}", path_, what));
}

GltfReader::View GltfReader::view(const json& accessor, std::size_t element) const {
  const json& views = document_.at("bufferViews");
  const auto number = accessor.at("bufferView").get<std::size_t>();
  const json& view = views.at(number);
  const auto buffer = view.value("buffer", std::size_t{0});
  if (buffer >= buffers_.size()) fail(fmt::format("no buffer {}", buffer));
  const std::string_view whole = buffers_[buffer];
  const auto from = view.value("byteOffset", std::size_t{0});
  const auto length = view.at("byteLength").get<std::size_t>();
  if (from > whole.size() || length > whole.size() - from)
    fail(fmt::format("bufferView {} ends beyond its buffer", number));
  const auto offset = accessor.value("byteOffset", std::size_t{0});
  if (offset > length) fail(fmt::format("an accessor begins beyond bufferView {}", number));
  return {whole.substr(from + offset, length - offset), view.value("byteStride", element)};
}

std::vector<double> GltfReader::numbers(std::size_t number, const std::string& type) const {
  try {
    const json& accessor = document_.at("accessors").at(number);
    const std::size_t width = type == "VEC3" ? 3 : 1;
    const int component_type = accessor.at("componentType").get<int>();
    const std::size_t bytes = component_size(component_type);
    if (accessor.at("type") != type || bytes == 0 || accessor.contains("sparse"))
      fail(fmt::format("accessor {} is not the plain {} that it should be", number, type));
    const auto count = accessor.at("count").get<std::size_t>();
    const View from = view(accessor, width * bytes);
    if (count > 0 && (from.stride < width * bytes || from.bytes.size() < width * bytes ||
                      (from.bytes.size() - width * bytes) / from.stride + 1 < count)) {
      fail(fmt::format("accessor {} ends beyond its bufferView", number));
    }
    std::vector<double> values;
    values.reserve(count * width);
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t k = 0; k < width; ++k) {
        values.push_back(
            component(from.bytes.data() + i * from.stride + k * bytes, component_type));
        if (!std::isfinite(values.back())) fail(fmt::format("accessor {} is not finite", number));
      }
    }
    return values;
  } catch (const json::exception& error) {
    fail(fmt::format("accessor {}: {}", number, error.what()));
  }
}

std::vector<std::int32_t> GltfReader::indices(std::size_t accessor) const {
  std::vector<std::int32_t> whole;
  for (const double value : numbers(accessor, "SCALAR")) {
    if (!(value >= 0 && value < 2147483647.0)) fail("an index is no number of a vertex");
    whole.push_back(static_cast<std::int32_t>(value));
  }
  return whole;
}

}  // namespace carillon::scene
