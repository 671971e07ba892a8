#include "solvers/mesh/readers/detail/text_scanner.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <boost/locale/encoding_utf.hpp>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "core/error.hpp"

namespace carillon::solvers::mesh::readers {
namespace {

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}

/// A word as it can stand in a message: printable and not endless.
std::string quoted(std::string_view word) {
  std::string text;
  for (const char c : word.substr(0, 40)) {
    text += std::isprint(static_cast<unsigned char>(c)) ? c : '?';
  }
  return "\"" + text + (word.size() > 40 ? "...\"" : "\"");
}

}  // namespace

std::string without_byte_order_mark(std::string bytes) {
  const auto begins = [&bytes](std::string_view mark) { return bytes.compare(0, 2, mark) == 0; };
  if (bytes.compare(0, 3, "\xEF\xBB\xBF") == 0) bytes.erase(0, 3);
  const bool low_first = begins("\xFF\xFE");
  if ((!low_first && !begins("\xFE\xFF")) || bytes.size() % 2 != 0) return bytes;
  std::u16string wide;
  for (std::size_t i = 2; i + 1 < bytes.size(); i += 2) {
    const auto first = static_cast<unsigned char>(bytes[i]);
    const auto second = static_cast<unsigned char>(bytes[i + 1]);
    wide += static_cast<char16_t>(low_first ? first | second << 8 : first << 8 | second);
  }
  return boost::locale::conv::utf_to_utf<char>(wide);
}

bool parse_number(std::string_view word, double& value) {
  if (word.size() > 1 && word.front() == '+' && word[1] != '-') word.remove_prefix(1);
  if (const auto exponent = word.find_first_of("Dd"); exponent != std::string_view::npos) {
    std::string usual(word);
    usual[exponent] = 'e';
    return parse_number(usual, value);
  }
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error == std::errc::result_out_of_range) {
    // Too small to be told from zero, or too large; strtod tells which.
    value = std::strtod(std::string(word).c_str(), nullptr);
  } else if (error != std::errc()) {
    return false;
  }
  return end == word.data() + word.size();
}

bool parse_integer(std::string_view word, std::int64_t& value) {
  if (word.size() > 1 && word.front() == '+' && word[1] != '-') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size();
}

bool same_word(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) {
    return std::tolower(static_cast<unsigned char>(x)) ==
           std::tolower(static_cast<unsigned char>(y));
  });
}

TextScanner::TextScanner(std::string path, std::string_view text, bool comments)
    : path_(std::move(path)), text_(text), comments_(comments) {}

bool TextScanner::next_line() {
  words_.clear();
  line_ = next_line_;
  while (position_ < text_.size()) {
    const char c = text_[position_];
    if (c == '\n' || c == '\r') {
      const bool pair = c == '\r' && text_.substr(position_ + 1, 1) == "\n";
      position_ += pair ? 2 : 1;
      ++next_line_;
      if (!words_.empty()) return true;
      line_ = next_line_;
    } else if (is_space(c)) {
      ++position_;
    } else if (c == '#' && comments_) {
      position_ = std::min(text_.find_first_of("\r\n", position_), text_.size());
    } else {
      const std::size_t begin = position_;
      while (position_ < text_.size()) {
        const char d = text_[position_];
        if (is_space(d) || d == '\n' || d == '\r' || (d == '#' && comments_)) break;
        ++position_;
      }
      std::string_view word = text_.substr(begin, position_ - begin);
      const bool ends_line =
          position_ == text_.size() || text_[position_] == '\n' || text_[position_] == '\r';
      if (word.back() == '\\' && ends_line) {
        word.remove_suffix(1);
        if (text_.substr(position_, 2) == "\r\n") ++position_;
        position_ = std::min(position_ + 1, text_.size());
        ++next_line_;
      }
      if (!word.empty()) words_.push_back(word);
    }
  }
  return !words_.empty();
}

double TextScanner::coordinate(std::string_view word, std::string_view what) const {
  double value = 0;
  if (!parse_number(word, value)) {
    fail(fmt::format("{} expected, found {}", what, quoted(word)));
  }
  return value;
}

double TextScanner::number(std::string_view word, std::string_view what) const {
  const double value = coordinate(word, what);
  if (!std::isfinite(value)) fail(fmt::format("{} is not finite: {}", what, quoted(word)));
  return value;
}

std::int64_t TextScanner::integer(std::string_view word, std::string_view what) const {
  std::int64_t value = 0;
  if (!parse_integer(word, value)) {
    fail(fmt::format("{} expected, found {}", what, quoted(word)));
  }
  return value;
}

std::string TextScanner::where() const {
  return fmt::format("{}:{}", path_, line_);
}

void TextScanner::fail(const std::string& message) const {
  throw core::InputError(fmt::format("{}: {}", where(), message));
}

}  // namespace carillon::solvers::mesh::readers
