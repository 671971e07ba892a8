#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace carillon::core {

/// Bytes as text (RFC 4648, with padding).
std::string base64(std::string_view bytes);

/// The way back; blanks and line breaks are passed over.
/// @throws InputError  it is no such text
std::string from_base64(std::string_view text);

/// Values as they lie in memory, little-endian on every machine that Carillon runs on.
template <class T>
std::string base64(std::span<const T> values) {
  return base64(std::string_view(reinterpret_cast<const char*>(values.data()),  // NOLINT
                                 values.size_bytes()));
}

}  // namespace carillon::core
