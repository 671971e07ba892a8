#pragma once

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "core/error.hpp"

namespace carillon::solvers::mesh::readers {

/// Reads binary numbers from a mesh file's bytes; never past their end.
class ByteReader {
 public:
  /// @param swap  the file's byte order is not this machine's
  ByteReader(std::string path, std::string_view bytes, std::size_t position, bool swap = false)
      : path_(std::move(path)), bytes_(bytes), position_(position), swap_(swap) {}

  /// @throws InputError  the file ends first
  template <class T>
  requires std::is_arithmetic_v<T> T read() {
    if (left() < sizeof(T)) fail("the file ends in the middle of its data");
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), bytes_.data() + position_, sizeof(T));
    if (swap_) std::reverse(raw.begin(), raw.end());
    position_ += sizeof(T);
    T value;
    std::memcpy(&value, raw.data(), sizeof(T));
    return value;
  }

  std::size_t left() const { return bytes_.size() - std::min(position_, bytes_.size()); }
  std::size_t position() const { return position_; }
  void skip(std::size_t bytes) { position_ += bytes; }
  void set_swap(bool swap) { swap_ = swap; }

  /// `file: byte position`
  std::string where() const { return fmt::format("{}: byte {}", path_, position_); }
  /// @throws InputError  `file: byte N: message`
  [[noreturn]] void fail(const std::string& message) const {
    throw core::InputError(fmt::format("{}: {}", where(), message));
  }

 private:
  std::string path_;
  std::string_view bytes_;
  std::size_t position_;
  bool swap_;
};

}  // namespace carillon::solvers::mesh::readers
