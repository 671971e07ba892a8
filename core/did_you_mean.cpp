#include "core/did_you_mean.hpp"

#include <fmt/format.h>

#include "core/units.hpp"

namespace carillon::core {

std::string did_you_mean(std::string_view word, const std::vector<std::string>& names) {
  std::vector<std::string> meant;
  const std::string part = fmt::format("_{}_", word);
  for (const std::string& name : names)
    if (!word.empty() && fmt::format("_{}_", name).find(part) != std::string::npos)
      meant.push_back(name);
  if (meant.empty()) {
    if (std::string nearest = nearest_name(word, names); !nearest.empty())
      meant.push_back(std::move(nearest));
  }
  constexpr std::size_t most = 6;
  if (meant.size() > most) meant.resize(most);
  std::string list;
  for (std::size_t i = 0; i < meant.size(); ++i) {
    const char* between = i == 0 ? "" : i + 1 < meant.size() ? ", " : " or ";
    list += fmt::format("{}\"{}\"", between, meant[i]);
  }
  return list.empty() ? "" : fmt::format("; did you mean {}?", list);
}

}  // namespace carillon::core
