#include <fmt/core.h>

#include <limits>

#include "core/error.hpp"
#include "solvers/mesh/readers/detail/read_formats.hpp"
#include "solvers/mesh/readers/detail/text_scanner.hpp"

namespace carillon::solvers::mesh::readers {
namespace {

/// Where each polygon stood, for messages about vertices that come later or never.
struct Reference {
  std::int64_t line;
  std::int64_t vertex;  ///< from 1, as written
};

/// Vertex index (from 0) of a corner "v", "v/vt", "v//vn" or "v/vt/vn".
std::int32_t corner_index(const TextScanner& scanner, std::string_view word, std::size_t vertices) {
  const std::string_view first = word.substr(0, word.find('/'));
  const std::int64_t written = scanner.integer(first, "vertex number of a face");
  const auto count = static_cast<std::int64_t>(vertices);
  if (written == 0) scanner.fail("vertex number 0: OBJ counts from 1");
  if (written < -count) {
    scanner.fail(
        fmt::format("vertex number {}: only {} vertices stand before this line", written, count));
  }
  const std::int64_t index = written > 0 ? written - 1 : count + written;
  if (index >= std::numeric_limits<std::int32_t>::max()) {
    scanner.fail(fmt::format("vertex number {} is too large", written));
  }
  return static_cast<std::int32_t>(index);
}

}  // namespace

PolygonMesh read_obj(const std::string& path, std::string_view bytes) {
  TextScanner scanner(path, bytes);
  PolygonMesh mesh;
  Reference furthest{0, 0};
  while (scanner.next_line()) {
    const auto& words = scanner.words();
    if (words[0] == "v") {
      if (words.size() < 4) scanner.fail("a vertex needs three coordinates");
      mesh.add_vertex({scanner.coordinate(words[1], "x coordinate"),
                       scanner.coordinate(words[2], "y coordinate"),
                       scanner.coordinate(words[3], "z coordinate")},
                      scanner);
    } else if (words[0] == "f" || words[0] == "fo") {
      if (words.size() < 4) scanner.fail("a face needs three vertices or more");
      for (std::size_t i = 1; i < words.size(); ++i) {
        const std::int32_t index = corner_index(scanner, words[i], mesh.vertices.size());
        if (index + 1 > furthest.vertex) furthest = {scanner.line(), index + 1};
        mesh.corners.push_back(index);
      }
      mesh.end_polygon();
    } else if (words[0] == "curv" || words[0] == "surf") {
      scanner.fail("free-form curves and surfaces are not read; export the object as polygons");
    }
    // Normals, texture coordinates, groups, materials, lines and points do not shape a body.
  }
  if (furthest.vertex > static_cast<std::int64_t>(mesh.vertices.size())) {
    throw core::InputError(fmt::format("{}:{}: a face refers to vertex {}, but there are {}", path,
                                       furthest.line, furthest.vertex, mesh.vertices.size()));
  }
  return mesh;
}

}  // namespace carillon::solvers::mesh::readers
