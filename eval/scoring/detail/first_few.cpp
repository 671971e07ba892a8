#include "eval/scoring/detail/first_few.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <span>

namespace carillon::eval::scoring {

std::string first_few(const std::vector<std::string>& all) {
  constexpr std::size_t few = 3;
  const auto first = std::span(all).first(std::min(few, all.size()));
  return fmt::format("{}{}", fmt::join(first, ", "),
                     all.size() > few ? fmt::format(" and {} more", all.size() - few) : "");
}

}  // namespace carillon::eval::scoring
