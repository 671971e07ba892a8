#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>

#include "core/error.hpp"
#include "solvers/mesh/readers/detail/byte_reader.hpp"
#include "solvers/mesh/readers/detail/read_formats.hpp"
#include "solvers/mesh/readers/detail/text_scanner.hpp"

namespace carillon::solvers::mesh::readers {
namespace {

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct Property {
  std::string name;
  Type type = Type::float32;       ///< of the value, or of a list's items
  std::optional<Type> count_type;  ///< set for lists
};

struct Element {
  std::string name;
  std::int64_t count = 0;
  std::vector<Property> properties;
};

enum class Encoding { ascii, little_endian, big_endian };

struct Header {
  Encoding encoding = Encoding::ascii;
  std::vector<Element> elements;
  std::size_t body = 0;  ///< where the data begin
};

Type parse_type(const TextScanner& scanner, std::string_view word) {
  static constexpr std::pair<std::string_view, Type> names[] = {
      {"char", Type::int8},      {"int8", Type::int8},       {"uchar", Type::uint8},
      {"uint8", Type::uint8},    {"short", Type::int16},     {"int16", Type::int16},
      {"ushort", Type::uint16},  {"uint16", Type::uint16},   {"int", Type::int32},
      {"int32", Type::int32},    {"uint", Type::uint32},     {"uint32", Type::uint32},
      {"float", Type::float32},  {"float32", Type::float32}, {"double", Type::float64},
      {"float64", Type::float64}};
  for (const auto& [name, type] : names) {
    if (word == name) return type;
  }
  scanner.fail(
      "unknown type of a property; char, uchar, short, ushort, int, uint, float or double "
      "expected");
}

void parse_format(const TextScanner& scanner, Header& header) {
  const auto& words = scanner.words();
  if (words.size() < 3) scanner.fail("\"format\" needs an encoding and a version");
  if (words[1] == "ascii") {
    header.encoding = Encoding::ascii;
  } else if (words[1] == "binary_little_endian") {
    header.encoding = Encoding::little_endian;
  } else if (words[1] == "binary_big_endian") {
    header.encoding = Encoding::big_endian;
  } else {
    scanner.fail("unknown encoding; ascii, binary_little_endian or binary_big_endian expected");
  }
}

void parse_property(const TextScanner& scanner, Header& header) {
  const auto& words = scanner.words();
  if (header.elements.empty()) scanner.fail("a property before any element");
  auto& properties = header.elements.back().properties;
  if (words.size() >= 5 && words[1] == "list") {
    const Type count_type = parse_type(scanner, words[2]);
    if (count_type == Type::float32 || count_type == Type::float64) {
      scanner.fail("the length of a list cannot be a fraction");
    }
    properties.push_back({std::string(words[4]), parse_type(scanner, words[3]), count_type});
  } else if (words.size() >= 3 && words[1] != "list") {
    properties.push_back({std::string(words[2]), parse_type(scanner, words[1]), {}});
  } else {
    scanner.fail("a property needs a type and a name");
  }
}

Header read_header(const std::string& path, std::string_view bytes) {
  if (bytes.substr(0, 3) != "ply") {
    throw core::InputError(fmt::format("{}:1: \"ply\" expected at the beginning", path));
  }
  // The line "end_header" ends the text; binary data follow the line feed at once.
  std::size_t end = bytes.find("end_header");
  while (end != std::string_view::npos && bytes[end - 1] != '\n' && bytes[end - 1] != '\r') {
    end = bytes.find("end_header", end + 1);
  }
  if (end == std::string_view::npos) {
    throw core::InputError(fmt::format("{}: the header has no \"end_header\"", path));
  }
  Header header;
  header.body = std::min(bytes.find_first_of("\r\n", end), bytes.size());
  if (bytes.substr(header.body, 2) == "\r\n") ++header.body;
  header.body = std::min(header.body + 1, bytes.size());

  TextScanner scanner(path, bytes.substr(0, end), false);
  bool has_format = false;
  while (scanner.next_line()) {
    const auto& words = scanner.words();
    if (words[0] == "format") {
      parse_format(scanner, header);
      has_format = true;
    } else if (words[0] == "element") {
      if (words.size() < 3) scanner.fail("an element needs a name and a count");
      const std::int64_t count = scanner.integer(words[2], "count of an element");
      if (count < 0) scanner.fail("negative count of an element");
      header.elements.push_back({std::string(words[1]), count, {}});
    } else if (words[0] == "property") {
      parse_property(scanner, header);
    }
  }
  if (!has_format) throw core::InputError(fmt::format("{}: the header has no \"format\"", path));
  return header;
}

/// Numbers of the body one after the other, whatever the encoding.
class Body {
 public:
  Body(const std::string& path, std::string_view bytes, const Header& header)
      : ascii_(header.encoding == Encoding::ascii),
        text_(path, ascii_ ? bytes : std::string_view(), false),
        binary_(path, bytes, header.body,
                (header.encoding == Encoding::big_endian) !=
                    (std::endian::native == std::endian::big)) {
    // The text scanner walks over the header, so that lines are counted from the file's first.
    if (!ascii_) return;
    while (text_.next_line() && text_.words()[0] != "end_header") {
    }
    word_ = text_.words().size();
  }

  double next(Type type) {
    if (ascii_) {
      const std::string_view word = next_word();
      double value = 0;
      if (!parse_number(word, value)) text_.fail("a number expected");
      return value;
    }
    switch (type) {
      case Type::int8:
        return binary_.read<std::int8_t>();
      case Type::uint8:
        return binary_.read<std::uint8_t>();
      case Type::int16:
        return binary_.read<std::int16_t>();
      case Type::uint16:
        return binary_.read<std::uint16_t>();
      case Type::int32:
        return binary_.read<std::int32_t>();
      case Type::uint32:
        return binary_.read<std::uint32_t>();
      case Type::float32:
        return binary_.read<float>();
      case Type::float64:
        return binary_.read<double>();
    }
    fail("unknown type");
  }

  std::string where() const { return ascii_ ? text_.where() : binary_.where(); }
  [[noreturn]] void fail(const std::string& message) const {
    if (ascii_) text_.fail(message);
    binary_.fail(message);
  }

 private:
  std::string_view next_word() {
    if (word_ >= text_.words().size()) {
      if (!text_.next_line()) text_.fail("the file ends in the middle of its data");
      word_ = 0;
    }
    return text_.words()[word_++];
  }

  bool ascii_;
  TextScanner text_;
  ByteReader binary_;
  std::size_t word_ = 0;
};

std::int32_t vertex_number(const Body& body, double value) {
  if (!(value >= 0) || value != std::floor(value) ||
      value >= std::numeric_limits<std::int32_t>::max()) {
    body.fail(fmt::format("a face refers to vertex {}", value));
  }
  return static_cast<std::int32_t>(value);
}

std::int64_t list_length(Body& body, const Property& property) {
  const double length = body.next(*property.count_type);
  if (!(length >= 0) || length != std::floor(length) || length > 1e15) {
    body.fail("the length of a list must be a whole number");
  }
  return static_cast<std::int64_t>(length);
}

void read_list(Body& body, const Property& property, bool is_face, PolygonMesh& mesh) {
  for (std::int64_t left = list_length(body, property); left > 0; --left) {
    const double value = body.next(property.type);
    if (is_face) mesh.corners.push_back(vertex_number(body, value));
  }
  if (is_face) mesh.end_polygon();
}

/// Strips of triangles, each ended by -1, every other one of them turned over.
void read_strips(Body& body, const Property& property, PolygonMesh& mesh) {
  std::vector<std::int32_t> strip;
  for (std::int64_t left = list_length(body, property); left > 0; --left) {
    const double value = body.next(property.type);
    if (value < 0) {
      strip.clear();
      continue;
    }
    strip.push_back(vertex_number(body, value));
    if (strip.size() < 3) continue;
    const std::size_t last = strip.size() - 1, turned = last % 2;
    for (const std::size_t corner : {last - 2 + turned, last - 1 - turned, last})
      mesh.corners.push_back(strip[corner]);
    mesh.end_polygon();
  }
}

void read_element(Body& body, const Element& element, PolygonMesh& mesh) {
  const bool is_vertex = element.name == "vertex";
  const bool is_face = element.name == "face";
  for (std::int64_t row = 0; row < element.count && !element.properties.empty(); ++row) {
    Vec3 point = Vec3::Zero();
    for (const Property& property : element.properties) {
      if (property.count_type) {
        const bool indices = property.name == "vertex_indices" || property.name == "vertex_index";
        if (element.name == "tristrips" && indices)
          read_strips(body, property, mesh);
        else
          read_list(body, property, is_face && indices, mesh);
        continue;
      }
      const double value = body.next(property.type);
      if (property.name == "x") point.x() = value;
      if (property.name == "y") point.y() = value;
      if (property.name == "z") point.z() = value;
    }
    if (is_vertex) mesh.add_vertex(point, body);
  }
}

void check_elements(const std::string& path, const Header& header) {
  bool points = false;
  bool faces = false;
  for (const Element& element : header.elements) {
    const auto has = [&](std::string_view name, bool list) {
      return std::any_of(
          element.properties.begin(), element.properties.end(),
          [&](const Property& p) { return p.name == name && p.count_type.has_value() == list; });
    };
    if (element.name == "vertex") points = has("x", false) && has("y", false) && has("z", false);
    if (element.name == "face" || element.name == "tristrips")
      faces = faces || has("vertex_indices", true) || has("vertex_index", true);
  }
  if (!points) {
    throw core::InputError(fmt::format("{}: no element \"vertex\" with x, y and z", path));
  }
  if (!faces) {
    throw core::InputError(
        fmt::format("{}: no element \"face\" with a list \"vertex_indices\"", path),
        "a cloud of points is not a surface");
  }
}

}  // namespace

PolygonMesh read_ply(const std::string& path, std::string_view bytes) {
  const Header header = read_header(path, bytes);
  check_elements(path, header);
  PolygonMesh mesh;
  Body body(path, bytes, header);
  for (const Element& element : header.elements) read_element(body, element, mesh);
  for (const std::int32_t index : mesh.corners) {
    if (static_cast<std::size_t>(index) >= mesh.vertices.size()) {
      throw core::InputError(fmt::format("{}: a face refers to vertex {}, but there are {}", path,
                                         index, mesh.vertices.size()));
    }
  }
  return mesh;
}

}  // namespace carillon::solvers::mesh::readers
