#include <fmt/format.h>

#include <array>
#include <cctype>
#include <limits>
#include <optional>

#include "core/error.hpp"
#include "core/npy.hpp"

namespace carillon::core {

namespace {

struct ElementName {
  const char* name;
  const char* numpy;
};
constexpr std::array<ElementName, 10> element_names = {{{"float32", "<f4"},
                                                        {"float64", "<f8"},
                                                        {"int8", "|i1"},
                                                        {"uint8", "|u1"},
                                                        {"int16", "<i2"},
                                                        {"uint16", "<u2"},
                                                        {"int32", "<i4"},
                                                        {"uint32", "<u4"},
                                                        {"int64", "<i8"},
                                                        {"uint64", "<u8"}}};

constexpr std::string_view magic = "\x93NUMPY";

/// The header's text, a literal of Python's: `{'descr': '<f4', 'fortran_order': False, 'shape':
/// (3, 4), }` with the keys in any order.
class Literal {
 public:
  explicit Literal(std::string_view text) : text_(text) {}

  bool take(char c) {
    skip_blanks();
    if (at_ == text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  void expect(char c) {
    if (!take(c)) fail(fmt::format("'{}' expected", c));
  }
  std::string quoted() {
    skip_blanks();
    const char quote = at_ < text_.size() ? text_[at_] : '\0';
    if (quote != '\'' && quote != '"') fail("a text in quotes expected");
    const std::size_t end = text_.find(quote, at_ + 1);
    if (end == std::string_view::npos) fail("a quote is not closed");
    const std::string text(text_.substr(at_ + 1, end - at_ - 1));
    at_ = end + 1;
    return text;
  }
  bool truth() {
    skip_blanks();
    for (const bool value : {true, false}) {
      const std::string_view name = value ? "True" : "False";
      if (text_.substr(at_, name.size()) != name) continue;
      at_ += name.size();
      return value;
    }
    fail("True or False expected");
  }
  std::uint64_t number() {
    skip_blanks();
    const std::size_t begin = at_;
    std::uint64_t value = 0;
    for (; at_ < text_.size() && std::isdigit(static_cast<unsigned char>(text_[at_])); ++at_) {
      const auto digit = static_cast<std::uint64_t>(text_[at_] - '0');
      if (value > (std::numeric_limits<std::uint64_t>::max() - digit) / 10) fail("too many rows");
      value = 10 * value + digit;
    }
    if (at_ == begin) fail("a number expected");
    if (at_ < text_.size() && text_[at_] == 'L') ++at_;  // written by Python 2
    return value;
  }
  std::vector<std::uint64_t> tuple() {
    std::vector<std::uint64_t> numbers;
    expect('(');
    while (!take(')')) {
      numbers.push_back(number());
      if (!take(',')) {
        expect(')');
        break;
      }
    }
    return numbers;
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(
        fmt::format("the header of a NumPy file is malformed at character {}: {}", at_, what),
        "write the array again with numpy.save");
  }

 private:
  void skip_blanks() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

std::string type_of(const std::string& numpy) {
  for (const ElementName& element : element_names) {
    // The order of a single byte does not matter, and is written in several ways.
    if (numpy == element.numpy ||
        (numpy.size() == 3 && numpy.substr(1) == element.numpy + 1 && numpy[2] == '1')) {
      return element.name;
    }
  }
  if (!numpy.empty() && numpy[0] == '>') {
    throw InputError(fmt::format("elements are big-endian ({})", numpy),
                     fmt::format("save array.astype('<{}')", numpy.substr(1)));
  }
  throw InputError(fmt::format("elements of type \"{}\" are not read", numpy),
                   "save array.astype('float32') or another type of real numbers");
}

NpyHeader parse_literal(std::string_view text) {
  Literal literal(text);
  std::optional<std::string> type;
  std::optional<bool> fortran;
  std::optional<std::vector<std::uint64_t>> extent;
  literal.expect('{');
  while (!literal.take('}')) {
    const std::string key = literal.quoted();
    literal.expect(':');
    if (key == "descr") {
      if (literal.take('[')) throw InputError("elements are records", "save one field as an array");
      type = type_of(literal.quoted());
    } else if (key == "fortran_order") {
      fortran = literal.truth();
    } else if (key == "shape") {
      extent = literal.tuple();
    } else {
      literal.fail(fmt::format("unknown key \"{}\"", key));
    }
    if (!literal.take(',')) {
      literal.expect('}');
      break;
    }
  }
  if (!type || !fortran || !extent) literal.fail("descr, fortran_order and shape expected");
  // One axis alone has no order.
  if (*fortran && extent->size() > 1) {
    throw InputError("the array lies column by column (Fortran order)",
                     "save numpy.ascontiguousarray(array)");
  }
  return {*type, *extent};
}

}  // namespace

std::string npy_header(const NpyHeader& header) {
  std::string shape, type;
  for (const std::uint64_t count : header.extent) shape += fmt::format("{}, ", count);
  for (const ElementName& element : element_names) {
    if (header.type == element.name) type = element.numpy;
  }
  if (type.empty()) {
    throw InputError(fmt::format("NumPy files do not hold elements of type {}", header.type));
  }
  std::string text =
      fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", type, shape);
  // Magic, version and length take 10 bytes; all of it a multiple of 64.
  constexpr std::size_t fixed = 10, multiple = 64;
  const std::size_t length = (fixed + text.size() + 1 + multiple - 1) / multiple * multiple - fixed;
  text.resize(length - 1, ' ');
  text += '\n';
  return std::string(magic) + std::string("\x01\x00", 2) + static_cast<char>(length & 0xff) +
         static_cast<char>(length >> 8) + text;
}

NpyHeader parse_npy_header(std::string_view bytes, std::uint64_t& offset) {
  const auto byte = [&](std::size_t place) {
    return static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[place]));
  };
  const InputError cut_off("the header of a NumPy file is cut off", "copy the file again");
  if (bytes.substr(0, magic.size()) != magic) {
    throw InputError("not a NumPy file: it does not begin with \\x93NUMPY",
                     "arrays are .npy files as numpy.save writes them");
  }
  if (bytes.size() < 10) throw cut_off;
  const std::uint64_t version = byte(6);
  if (version < 1 || version > 3) {
    throw InputError(fmt::format("NumPy's format {} is not known", version),
                     "formats 1.0, 2.0 and 3.0 are read");
  }
  const std::size_t begin = version == 1 ? 10 : 12;
  if (bytes.size() < begin) throw cut_off;
  std::uint64_t length = byte(8) | byte(9) << 8;
  if (version > 1) length |= byte(10) << 16 | byte(11) << 24;
  if (bytes.size() - begin < length) throw cut_off;
  offset = begin + length;
  return parse_literal(bytes.substr(begin, length));
}

}  // namespace carillon::core
