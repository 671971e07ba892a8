#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "eval/perception/compare_sounds.hpp"

namespace carillon::eval::perception {

/// Two files, what is heard in them, and how they differ.
struct ComparedFiles {
  std::string reference_file;
  std::string other_file;
  HeardSound reference;
  HeardSound other;
  SoundComparison comparison;
};

/// As --json prints it; docs/comparison.md names the fields.
nlohmann::json to_json(const ComparedFiles& compared);

/// For people.
void print_comparison(const ComparedFiles& compared);

}  // namespace carillon::eval::perception
