#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "solvers/mesh/readers/detail/byte_reader.hpp"
#include "solvers/mesh/readers/detail/read_formats.hpp"
#include "solvers/mesh/readers/detail/text_scanner.hpp"

namespace carillon::solvers::mesh::readers {
namespace {

constexpr std::size_t header_bytes = 84;  // 80 of text and the number of triangles
constexpr std::size_t facet_bytes = 50;   // normal, three corners, two bytes of attributes

/// Marks of comment lines beside #.
bool is_comment(std::string_view word) {
  return word.starts_with(";") || word.starts_with("//") || word.starts_with("!");
}

/// The format shares no vertices: each corner has its own.
void add_corner(PolygonMesh& mesh, double x, double y, double z) {
  mesh.corners.push_back(static_cast<std::int32_t>(mesh.vertices.size()));
  mesh.vertices.emplace_back(x + 0.0, y + 0.0, z + 0.0);  // turns -0 into 0
}

/// Triangles of a binary file. The header's count holds, unless facets follow those it counts;
/// a facet's last two bytes may count bytes of its own that follow (attributes), if that is how the
/// file comes out even.
struct Layout {
  std::size_t facets = 0;
  bool has_payloads = false;
};

/// Corners of facets of a binary file.
std::vector<Vec3> corners_of(const std::string& path, std::string_view bytes, std::size_t from,
                             std::size_t to) {
  std::vector<Vec3> corners;
  for (std::size_t i = from; i < to; ++i) {
    ByteReader reader(path, bytes, header_bytes + i * facet_bytes + 3 * sizeof(float),
                      std::endian::native == std::endian::big);
    for (int corner = 0; corner < 3; ++corner) {
      Vec3& point = corners.emplace_back();
      for (Eigen::Index k = 0; k < 3; ++k) point[k] = reader.read<float>();
    }
  }
  return corners;
}

/// Whether what follows the facets that were promised are more of them: finite, and no farther from
/// the first ones than those reach.
bool are_facets(const std::string& path, std::string_view bytes, std::size_t promised,
                std::size_t room) {
  const std::size_t known = std::max<std::size_t>(promised, 1);
  const Box box = bounding_box(corners_of(path, bytes, 0, known));
  // One facet alone says little of how far the others may be.
  const double away = (known > 1 ? 2 : 1000) * box.longest_side();
  const std::vector<Vec3> further = corners_of(path, bytes, promised, room);
  return std::all_of(further.begin(), further.end(), [&](const Vec3& corner) {
    return corner.allFinite() && (corner - box.low).minCoeff() > -away &&
           (corner - box.high).maxCoeff() < away;
  });
}

Layout layout_of(const std::string& path, std::string_view bytes, std::uint32_t count) {
  const std::size_t room = (bytes.size() - header_bytes) / facet_bytes;
  const std::size_t rest = (bytes.size() - header_bytes) % facet_bytes;
  if (room == count && rest == 0) return {count, false};
  std::size_t end = header_bytes;
  std::uint32_t walked = 0;
  for (; walked < count && end + facet_bytes <= bytes.size(); ++walked) {
    ByteReader reader(path, bytes, end + facet_bytes - 2, std::endian::native == std::endian::big);
    end += facet_bytes + reader.read<std::uint16_t>();
  }
  if (count > 0 && walked == count && end == bytes.size()) return {count, true};
  if (room > count && rest == 0) return {room, false};
  if (room > count && are_facets(path, bytes, count, room)) return {room, false};
  if (room < count || count == 0) {
    throw core::InputError(fmt::format(
        "{}: the header promises {} triangles, but the file ends after {}", path, count, room));
  }
  return {count, false};
}

PolygonMesh read_binary(const std::string& path, std::string_view bytes, std::uint32_t count) {
  const Layout layout = layout_of(path, bytes, count);
  PolygonMesh mesh;
  ByteReader reader(path, bytes, header_bytes, std::endian::native == std::endian::big);
  for (std::size_t i = 0; i < layout.facets; ++i) {
    std::array<float, 12> values;
    for (float& value : values) value = reader.read<float>();
    const auto attributes = reader.read<std::uint16_t>();
    if (layout.has_payloads) reader.skip(attributes);
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

/// Words of a line, "end facet" and the like as one.
std::vector<std::string> words_of(const TextScanner& scanner) {
  std::vector<std::string> words(scanner.words().begin(), scanner.words().end());
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    if (!same_word(words[i], "end")) continue;
    words[i] += words[i + 1];
    words.erase(words.begin() + static_cast<std::ptrdiff_t>(i) + 1);
  }
  return words;
}

PolygonMesh read_ascii(const std::string& path, std::string_view bytes) {
  TextScanner scanner(path, bytes);
  PolygonMesh mesh;
  bool begun = false;  // whatever stands before the first solid or facet is a comment
  int corners = -1;    // of the loop that is open; -1: none
  while (scanner.next_line()) {
    const std::vector<std::string> words = words_of(scanner);
    begun = begun || same_word(words[0], "solid") || same_word(words[0], "facet");
    if (!begun || is_comment(words[0])) continue;
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

/// Whether a line of text begins as an ASCII file's first solid or facet does.
bool says_solid(std::string_view text) {
  TextScanner scanner("", text);
  while (scanner.next_line())
    if (same_word(scanner.words()[0], "solid") || same_word(scanner.words()[0], "facet"))
      return true;
  return false;
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
  // Text has no zero bytes.
  const std::string_view beginning = bytes.substr(0, 4096);
  if (beginning.find('\0') == std::string_view::npos && says_solid(beginning))
    return read_ascii(path, bytes);
  if (bytes.size() < header_bytes) {
    throw core::InputError(fmt::format(
        "{}: not an STL file: neither \"solid\" nor a binary header of 84 bytes", path));
  }
  return read_binary(path, bytes, count);
}

}  // namespace carillon::solvers::mesh::readers
