#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

namespace carillon::solvers::mesh::readers {

/// Numbers of an MSH file one after the other: words of text, or binary values once set so.
/// Positions are the file's bytes.
class MshSource {
 public:
  MshSource(std::string path, std::string_view bytes) : path_(std::move(path)), bytes_(bytes) {}

  /// Next word of text; "" at the end.
  std::string_view word();
  /// Rest of the line, without the space around it.
  std::string_view line();
  std::int64_t text_integer(const char* what);
  double text_number(const char* what);

  /// Numbers that are text in an ASCII file and of the given type in a binary one.
  std::int64_t integer(const char* what);  ///< int32
  std::int64_t size(const char* what);     ///< size_t of MSH 4.1
  double number(const char* what);         ///< double, finite
  /// A count of things that each take `minimum` bytes or more of the rest of the file.
  std::int64_t count(std::int64_t value, std::size_t minimum, const char* what) const;

  /// Steps over the line feed that stands before binary data.
  void begin_binary();
  /// Moves behind `$EndNAME` wherever it is.
  void skip_section(std::string_view name);
  /// Expects `$EndNAME` here.
  void end_section(std::string_view name);

  bool binary = false;
  bool swap = false;

  [[noreturn]] void fail(const std::string& message) const;

 private:
  template <class T>
  T raw();
  std::string path_;
  std::string_view bytes_;
  std::size_t position_ = 0;
};

}  // namespace carillon::solvers::mesh::readers
