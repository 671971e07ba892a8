#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "core/error.hpp"
#include "solvers/mesh/readers/detail/read_formats.hpp"
#include "solvers/mesh/readers/detail/text_scanner.hpp"

namespace carillon::solvers::mesh::readers {
namespace {

struct Counts {
  std::int64_t vertices = 0;
  std::int64_t faces = 0;
  std::size_t columns = 3;  ///< numbers of a vertex
};

/// The header's keyword and counts: "OFF", a line feed, "8 6 12"; but also "OFF 8 6 12",
/// ModelNet's "OFF8 6 12", a missing number of edges, and the variants with normals, colours or
/// texture coordinates (ST, C, N before OFF), whose extra columns follow the coordinates.
Counts read_header(TextScanner& scanner) {
  if (!scanner.next_line()) scanner.fail("empty file; \"OFF\" expected");
  std::string_view keyword = scanner.words()[0];
  const std::size_t off = keyword.find("OFF");
  const std::string_view prefix = keyword.substr(0, std::min(off, keyword.size()));
  if (off == std::string_view::npos ||
      prefix.find_first_not_of("STCN4n") != std::string_view::npos) {
    scanner.fail("\"OFF\" expected at the beginning");
  }
  if (prefix.find('4') != std::string_view::npos || prefix.find('n') != std::string_view::npos) {
    scanner.fail("OFF with four or n coordinates is not a surface in space");
  }
  Counts counts;
  for (const auto& [letter, more] : {std::pair('N', 3), {'C', 4}, {'S', 2}})
    counts.columns += prefix.find(letter) != std::string_view::npos ? more : 0;
  std::vector<std::string_view> numbers;
  if (off + 3 < keyword.size()) numbers.push_back(keyword.substr(off + 3));
  numbers.insert(numbers.end(), scanner.words().begin() + 1, scanner.words().end());
  if (!numbers.empty() && same_word(numbers[0], "BINARY")) {
    scanner.fail("binary OFF is not read; save as text");
  }
  // Two counts at the least; that of edges may be missing, and each may have a line of its own.
  while (numbers.size() < 2) {
    if (!scanner.next_line()) scanner.fail("numbers of vertices and faces expected");
    numbers.insert(numbers.end(), scanner.words().begin(), scanner.words().end());
  }
  counts.vertices = scanner.integer(numbers[0], "number of vertices");
  counts.faces = scanner.integer(numbers[1], "number of faces");
  if (counts.vertices < 0 || counts.faces < 0) scanner.fail("negative number of vertices or faces");
  if (counts.vertices > std::numeric_limits<std::int32_t>::max()) scanner.fail("too many vertices");
  return counts;
}

std::int32_t vertex_number(const TextScanner& scanner, std::string_view word,
                           const Counts& counts) {
  const std::int64_t index = scanner.integer(word, "vertex number of a face");
  if (index < 0 || index >= counts.vertices) {
    scanner.fail(fmt::format("a face refers to vertex {}, but they run from 0 to {}", index,
                             counts.vertices - 1));
  }
  return static_cast<std::int32_t>(index);
}

/// A vertex or a face to a line, as nearly all files have them: colours may follow on it.
PolygonMesh read_lines(const std::string& path, std::string_view bytes) {
  TextScanner scanner(path, bytes);
  const Counts counts = read_header(scanner);
  PolygonMesh mesh;
  // A vertex takes six characters or more: what a wrong header claims is not reserved.
  mesh.vertices.reserve(std::min(static_cast<std::size_t>(counts.vertices), bytes.size() / 6 + 1));
  for (std::int64_t i = 0; i < counts.vertices; ++i) {
    if (!scanner.next_line()) {
      scanner.fail(fmt::format("the file ends after {} of {} vertices", i, counts.vertices));
    }
    const auto& words = scanner.words();
    if (words.size() < 3) scanner.fail("a vertex needs three coordinates");
    mesh.add_vertex(
        {scanner.coordinate(words[0], "x coordinate"), scanner.coordinate(words[1], "y coordinate"),
         scanner.coordinate(words[2], "z coordinate")},
        scanner);
  }
  for (std::int64_t i = 0; i < counts.faces; ++i) {
    if (!scanner.next_line()) {
      scanner.fail(fmt::format("the file ends after {} of {} faces", i, counts.faces));
    }
    const auto& words = scanner.words();
    const std::int64_t corners = scanner.integer(words[0], "number of corners");
    if (corners < 1 || corners > static_cast<std::int64_t>(words.size()) - 1) {
      scanner.fail(
          fmt::format("a face of {} corners, but {} numbers follow", corners, words.size() - 1));
    }
    for (std::int64_t k = 1; k <= corners; ++k) {
      mesh.corners.push_back(vertex_number(scanner, words[static_cast<std::size_t>(k)], counts));
    }
    mesh.end_polygon();
  }
  return mesh;
}

/// Numbers one after the other wherever lines end, as the format's definition allows; no colours of
/// faces then.
PolygonMesh read_stream(const std::string& path, std::string_view bytes) {
  TextScanner scanner(path, bytes);
  std::size_t at = 0;
  const auto next = [&]() -> std::string_view {
    if (at >= scanner.words().size()) {
      if (!scanner.next_line()) scanner.fail("the file ends in the middle of its data");
      at = 0;
    }
    return scanner.words()[at++];
  };
  // The header ends with the count of edges, wherever that stands.
  const std::string_view keyword = next();
  Counts counts;
  {
    TextScanner header(path, bytes);
    counts = read_header(header);
  }
  if (keyword.substr(keyword.find("OFF")).size() == 3) next();
  next();
  next();
  PolygonMesh mesh;
  for (std::int64_t i = 0; i < counts.vertices; ++i) {
    Vec3 point;
    for (Eigen::Index k = 0; k < 3; ++k) point[k] = scanner.coordinate(next(), "a coordinate");
    for (std::size_t k = 3; k < counts.columns; ++k) next();
    mesh.add_vertex(point, scanner);
  }
  for (std::int64_t i = 0; i < counts.faces; ++i) {
    const std::int64_t corners = scanner.integer(next(), "number of corners");
    if (corners < 1) scanner.fail(fmt::format("a face of {} corners", corners));
    for (std::int64_t k = 0; k < corners; ++k)
      mesh.corners.push_back(vertex_number(scanner, next(), counts));
    mesh.end_polygon();
  }
  if (at < scanner.words().size() || scanner.next_line())
    scanner.fail("numbers follow the last face");
  return mesh;
}

}  // namespace

PolygonMesh read_off(const std::string& path, std::string_view bytes) {
  try {
    return read_lines(path, bytes);
  } catch (const core::InputError&) {
    try {
      return read_stream(path, bytes);
    } catch (const core::InputError&) {
    }
    throw;
  }
}

}  // namespace carillon::solvers::mesh::readers
