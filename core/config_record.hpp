#pragma once

#include <functional>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/units.hpp"

namespace carillon::core {

/// What a reader takes under a key: an ask of ConfigNode, by the name of its member function.
struct ConfigAsk {
  std::string_view kind;  ///< "quantity", "range", ...; "names": the mapping's keys are the user's
  Dimension dimension = Dimension::none;
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool above_low = false;                     ///< `low` itself is refused
  std::size_t count = 0;                      ///< elements of a list; 0: any number
  std::span<const std::string> allowed = {};  ///< of a choice
  bool optional = false;                      ///< the key may be missing
};

/// Hears of every ask that is answered.
/// @param file      name of the document
/// @param path      keys from the root; "[0]" is an element of a list
/// @param fallback  what a missing key was answered by, as the resolved configuration has it; null
///                  where the key was there
using HearAsk = std::function<void(const std::string& file, const std::vector<std::string>& path,
                                   const ConfigAsk& ask, const std::string* fallback)>;

/// While it lives, what this thread reads of configurations is heard.
class ConfigRecord {
 public:
  explicit ConfigRecord(HearAsk hear);
  ~ConfigRecord();
  ConfigRecord(const ConfigRecord&) = delete;
  ConfigRecord& operator=(const ConfigRecord&) = delete;
};

}  // namespace carillon::core
