#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

namespace carillon::dataset::exporters {

/// A glTF document under way: JSON, and the one buffer that its accessors point into (Khronos,
/// glTF 2.0 specification, sections 3.6 and 4.4). All numbers little-endian.
class GlbFile {
 public:
  nlohmann::ordered_json document;  ///< without what the functions below fill in

  /// @return number of the accessor. Vertices are aligned and have least and largest values, which
  ///         glTF asks of positions.
  std::size_t add_vertices(std::span<const std::array<float, 3>> values, bool with_range);
  std::size_t add_indices(std::span<const std::uint32_t> values);
  /// Times of keyframes, ascending.
  std::size_t add_times(std::span<const float> values);
  /// Any other single numbers.
  std::size_t add_numbers(std::span<const float> values);
  /// What no mesh has for vertices or indices.
  std::size_t add_vectors(std::span<const std::array<float, 3>> values);
  std::size_t add_whole_numbers(std::span<const std::uint32_t> values);

  /// The whole file.
  /// @throws InputError  more than 4 GiB
  std::string bytes() const;

 private:
  std::size_t add(std::span<const std::byte> bytes, int component_type, const char* type,
                  std::size_t count, int target);
  std::string buffer_;
  nlohmann::ordered_json views_ = nlohmann::ordered_json::array();
  nlohmann::ordered_json accessors_ = nlohmann::ordered_json::array();
};

}  // namespace carillon::dataset::exporters
