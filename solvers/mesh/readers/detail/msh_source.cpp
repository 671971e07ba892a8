#include "solvers/mesh/readers/detail/msh_source.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/text.hpp"
#include "solvers/mesh/readers/detail/byte_reader.hpp"
#include "solvers/mesh/readers/detail/text_scanner.hpp"

namespace carillon::solvers::mesh::readers {
namespace {

constexpr std::string_view space = " \t\r\n\v\f";

}  // namespace

std::string_view MshSource::word() {
  position_ = std::min(bytes_.find_first_not_of(space, position_), bytes_.size());
  const std::size_t end = std::min(bytes_.find_first_of(space, position_), bytes_.size());
  const std::string_view found = bytes_.substr(position_, end - position_);
  position_ = end;
  return found;
}

std::string_view MshSource::line() {
  const std::size_t end = std::min(bytes_.find('\n', position_), bytes_.size());
  const std::string_view found = bytes_.substr(position_, end - position_);
  position_ = std::min(end + 1, bytes_.size());
  return core::trimmed(found);
}

std::int64_t MshSource::text_integer(const char* what) {
  std::int64_t value = 0;
  if (!parse_integer(word(), value)) fail(fmt::format("{} expected", what));
  return value;
}

double MshSource::text_number(const char* what) {
  double value = 0;
  if (!parse_number(word(), value)) fail(fmt::format("{} expected", what));
  if (!std::isfinite(value)) fail(fmt::format("{} is not finite", what));
  return value;
}

template <class T>
T MshSource::raw() {
  ByteReader reader(path_, bytes_, position_, swap);
  const T value = reader.read<T>();
  position_ = reader.position();
  return value;
}

std::int64_t MshSource::integer(const char* what) {
  return binary ? raw<std::int32_t>() : text_integer(what);
}

std::int64_t MshSource::size(const char* what) {
  return binary ? raw<std::int64_t>() : text_integer(what);
}

double MshSource::number(const char* what) {
  if (!binary) return text_number(what);
  const double value = raw<double>();
  if (!std::isfinite(value)) fail(fmt::format("{} is not finite", what));
  return value;
}

std::int64_t MshSource::count(std::int64_t value, std::size_t minimum, const char* what) const {
  const auto maximum = static_cast<std::int64_t>((bytes_.size() - position_) / minimum);
  if (value < 0 || value > maximum) {
    fail(fmt::format("{} {}: more than the rest of the file can hold", value, what));
  }
  return value;
}

void MshSource::begin_binary() {
  while (position_ < bytes_.size() && bytes_[position_] != '\n') ++position_;
  position_ = std::min(position_ + 1, bytes_.size());
}

void MshSource::skip_section(std::string_view name) {
  const std::size_t end = bytes_.find(fmt::format("$End{}", name), position_);
  if (end == std::string_view::npos) fail(fmt::format("${} has no $End{}", name, name));
  position_ = end;
  word();
}

void MshSource::end_section(std::string_view name) {
  if (word() != fmt::format("$End{}", name)) fail(fmt::format("$End{} expected", name));
}

void MshSource::fail(const std::string& message) const {
  // In text a line helps more than a byte.
  const auto lines =
      std::count(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(position_), '\n');
  throw core::InputError(binary ? fmt::format("{}: byte {}: {}", path_, position_, message)
                                : fmt::format("{}:{}: {}", path_, lines + 1, message));
}

}  // namespace carillon::solvers::mesh::readers
