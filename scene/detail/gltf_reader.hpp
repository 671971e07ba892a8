#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/vectors.hpp"

namespace carillon::scene {

/// A glTF 2.0 document with its buffers: binary, or text with buffers inside or beside it.
class GltfReader {
 public:
  /// @throws FileError   cannot be read
  /// @throws InputError  it is no glTF, or a buffer is not there
  explicit GltfReader(const std::string& path);

  const nlohmann::json& document() const { return document_; }

  /// Values of an accessor, as many numbers to each as its type has. Sparse accessors and
  /// normalised integers are none that the callers need.
  /// @param type  "SCALAR" or "VEC3"
  /// @throws InputError  no such accessor, another type, or beyond its buffer
  std::vector<double> numbers(std::size_t accessor, const std::string& type) const;
  /// Whole numbers of a SCALAR accessor.
  std::vector<std::int32_t> indices(std::size_t accessor) const;

  /// @throws InputError  always, with the file's name
  [[noreturn]] void fail(const std::string& what) const;

 private:
  /// A view of a buffer from an offset on, and the distance of its elements [byte].
  struct View {
    std::string_view bytes;
    std::size_t stride;
  };
  View view(const nlohmann::json& accessor, std::size_t element) const;

  std::string path_;
  nlohmann::json document_;
  std::vector<std::string> buffers_;
};

}  // namespace carillon::scene
