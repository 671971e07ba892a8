#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "core/error.hpp"
#include "solvers/mesh/readers/detail/byte_reader.hpp"
#include "solvers/mesh/readers/detail/read_formats.hpp"
#include "solvers/mesh/readers/detail/text_scanner.hpp"

namespace carillon::solvers::mesh::readers {
namespace {

constexpr std::size_t header_bytes = 84;  // 80 of text and the number of triangles
constexpr std::size_t facet_bytes = 50;   // normal, three corners, two bytes of attributes

/// The format shares no vertices: each corner has its own.
void add_corner(PolygonMesh& mesh, double x, double y, double z) {
  mesh.corners.push_back(static_cast<std::int32_t>(mesh.vertices.size()));
  mesh.vertices.emplace_back(x + 0.0, y + 0.0, z + 0.0);  // turns -0 into 0
}

PolygonMesh read_binary(const std::string& path, std::string_view bytes, std::uint32_t count) {
  if ((bytes.size() - header_bytes) / facet_bytes < count) {
    throw core::InputError(
        fmt::format("{}: the header promises {} triangles, but the file ends after {}", path, count,
                    (bytes.size() - header_bytes) / facet_bytes));
  }
  PolygonMesh mesh;
  ByteReader reader(path, bytes, header_bytes, std::endian::native == std::endian::big);
  for (std::uint32_t i = 0; i < count; ++i) {
    std::array<float, 12> values;
    for (float& value : values) value = reader.read<float>();
    reader.read<std::uint16_t>();
    // The stored normal is often wrong or zero; the corners' order decides.
    for (std::size_t k = 3; k < 12; ++k) {
      if (!std::isfinite(values[k])) {
        reader.fail(fmt::format("triangle {} has a corner that is not finite", i + 1));
      }
    }
    for (std::size_t k = 3; k < 12; k += 3) {
      add_corner(mesh, values[k], values[k + 1], values[k + 2]);
    }
    mesh.end_polygon();
  }
  return mesh;
}

PolygonMesh read_ascii(const std::string& path, std::string_view bytes) {
  TextScanner scanner(path, bytes, false);
  PolygonMesh mesh;
  int corners = -1;  // of the loop that is open; -1: none
  while (scanner.next_line()) {
    const auto& words = scanner.words();
    // "facet normal ... outer loop" may share a line with what follows: words, not lines, count.
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (same_word(words[i], "solid") || same_word(words[i], "endsolid")) {
        break;  // the rest of the line is a name
      }
      if (same_word(words[i], "loop")) {
        if (corners >= 0) scanner.fail("\"outer loop\" inside a loop");
        corners = 0;
      } else if (same_word(words[i], "vertex")) {
        if (corners < 0) scanner.fail("\"vertex\" outside of a loop");
        if (words.size() - i < 4) scanner.fail("a vertex needs three coordinates");
        const double x = scanner.number(words[i + 1], "x coordinate");
        const double y = scanner.number(words[i + 2], "y coordinate");
        const double z = scanner.number(words[i + 3], "z coordinate");
        add_corner(mesh, x, y, z);
        ++corners;
        i += 3;
      } else if (same_word(words[i], "endloop")) {
        if (corners < 3) scanner.fail("a facet needs three vertices");
        mesh.end_polygon();
        corners = -1;
      } else if (same_word(words[i], "facet")) {
        // "normal" and its three numbers are not read: the corners' order decides.
        i += std::min<std::size_t>(4, words.size() - i - 1);
      } else if (!same_word(words[i], "outer") && !same_word(words[i], "endfacet")) {
        scanner.fail("\"facet\", \"vertex\" or \"endsolid\" expected");
      }
    }
  }
  if (corners >= 0) scanner.fail("the file ends inside a facet");
  return mesh;
}

}  // namespace

PolygonMesh read_stl(const std::string& path, std::string_view bytes) {
  // Binary files may begin with "solid" too; what tells is whether the size fits the count.
  std::uint32_t count = 0;
  if (bytes.size() >= header_bytes) {
    count =
        ByteReader(path, bytes, 80, std::endian::native == std::endian::big).read<std::uint32_t>();
    if (bytes.size() == header_bytes + facet_bytes * std::size_t{count}) {
      return read_binary(path, bytes, count);
    }
  }
  const std::size_t begin = bytes.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  const bool says_solid =
      begin != std::string_view::npos && same_word(bytes.substr(begin, 5), "solid");
  // Text has no zero bytes.
  const bool is_text = bytes.substr(0, 4096).find('\0') == std::string_view::npos;
  if (says_solid && is_text) return read_ascii(path, bytes);
  if (bytes.size() < header_bytes) {
    throw core::InputError(fmt::format(
        "{}: not an STL file: neither \"solid\" nor a binary header of 84 bytes", path));
  }
  return read_binary(path, bytes, count);
}

}  // namespace carillon::solvers::mesh::readers
