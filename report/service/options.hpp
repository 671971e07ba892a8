#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/text.hpp"
#include "report/service/http_message.hpp"

namespace carillon::report::service {

/// The query's options; what is left when all are taken is refused.
class Options {
 public:
  explicit Options(const HttpRequest& request) : left_(request.query) { left_.erase("token"); }

  std::string text(const std::string& name, const std::string& fallback) {
    known_.push_back(name);
    const auto at = left_.find(name);
    if (at == left_.end()) return fallback;
    std::string value = at->second;
    left_.erase(at);
    return value;
  }
  /// @throws InputError  it is none, or beyond the range
  double number(const std::string& name, double fallback, double low, double high) {
    const std::string value = text(name, "");
    if (value.empty()) return fallback;
    const std::optional<double> number = core::number_in<double>(value);
    if (!number || !(*number >= low && *number <= high)) {
      throw core::InputError(fmt::format("{} is \"{}\", and a number from {:g} to {:g} is wanted",
                                         name, value, low, high));
    }
    return *number;
  }
  /// A whole one.
  std::size_t count(const std::string& name, std::size_t fallback, std::size_t low,
                    std::size_t high) {
    const std::string value = text(name, "");
    if (value.empty()) return fallback;
    const std::optional<std::int64_t> number = core::number_in<std::int64_t>(value);
    if (!number || *number < static_cast<std::int64_t>(low) ||
        *number > static_cast<std::int64_t>(high)) {
      throw core::InputError(fmt::format("{} is \"{}\", and a whole number from {} to {} is wanted",
                                         name, value, low, high));
    }
    return static_cast<std::size_t>(*number);
  }
  /// @throws InputError  there is one more
  void finish() const {
    if (left_.empty()) return;
    throw core::InputError(fmt::format("there is no option \"{}\" here", left_.begin()->first),
                           fmt::format("there are {}", fmt::join(known_, ", ")));
  }

 private:
  std::map<std::string, std::string> left_;
  std::vector<std::string> known_;
};

}  // namespace carillon::report::service
