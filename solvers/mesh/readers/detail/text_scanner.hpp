#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace carillon::solvers::mesh::readers {

/// Walks the words of a mesh file's text and knows the line it is on, for messages that begin
/// with `file:line:`. LF, CRLF and CR end lines; `#` starts a comment where comments are on; a
/// backslash at a line's end joins the next line.
class TextScanner {
 public:
  TextScanner(std::string path, std::string_view text, bool comments = true);

  /// Moves to the next line that holds words; false at the end of the text.
  bool next_line();
  /// Words of the line that next_line() moved to.
  const std::vector<std::string_view>& words() const { return words_; }
  /// Number of that line, from 1.
  std::int64_t line() const { return line_; }

  /// A finite number. @throws InputError  names the line and `what`
  double number(std::string_view word, std::string_view what) const;
  /// One that may also be a NaN or an infinity.
  double coordinate(std::string_view word, std::string_view what) const;
  std::int64_t integer(std::string_view word, std::string_view what) const;

  /// `file:line`
  std::string where() const;
  /// @throws InputError  `file:line: message`
  [[noreturn]] void fail(const std::string& message) const;

 private:
  std::string path_;
  std::string_view text_;
  bool comments_;
  std::size_t position_ = 0;
  std::int64_t line_ = 0;
  std::int64_t next_line_ = 1;
  std::vector<std::string_view> words_;
};

/// Bytes of a file as text that the readers know: UTF-16 that begins with its byte order mark
/// becomes UTF-8, the mark of UTF-8 goes. Other bytes stay.
std::string without_byte_order_mark(std::string bytes);

/// Reads a number in any usual spelling ("1", "+1.5", "1e-400", Fortran's "5.0D-02"); false when
/// `word` is none.
bool parse_number(std::string_view word, double& value);
bool parse_integer(std::string_view word, std::int64_t& value);

/// Same letters, upper or lower case.
bool same_word(std::string_view a, std::string_view b);

}  // namespace carillon::solvers::mesh::readers
