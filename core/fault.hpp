#pragma once

#include <string>

namespace carillon::core {

/// The first rule that something breaks, for those who know its place in a file.
struct Fault {
  std::string key;  ///< "alpha2"
  std::string message;
  std::string hint;
};

}  // namespace carillon::core
