#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace carillon::core {

/// Bytes of equal weight of all values side by side, as HDF5's shuffle filter puts them.
/// @param values  whole elements of `element_size` bytes
std::vector<unsigned char> byte_planes(std::span<const unsigned char> values,
                                       std::size_t element_size);

/// The way back.
/// @param planes  as many bytes as `values`
void from_byte_planes(std::span<const unsigned char> planes, std::size_t element_size,
                      std::span<unsigned char> values);

/// A zlib stream (RFC 1950) of byte planes, as HDF5's deflate filter makes it of them. Planes whose
/// bytes are as good as random, as the low ones of measured and computed numbers, are stored as
/// they are: they would take nearly all of the time and save nothing.
/// @param level  1 to 9
std::vector<unsigned char> deflate_planes(std::span<const unsigned char> planes,
                                          std::size_t element_size, int level);

/// The way back.
/// @param planes  to be filled
/// @return false where the stream is damaged, or not of so many bytes
bool inflate_planes(std::span<const unsigned char> deflated, std::span<unsigned char> planes);

}  // namespace carillon::core
