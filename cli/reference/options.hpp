#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace carillon::cli {

/// One option of a command, as help, completion and manual know it.
struct OptionText {
  std::vector<std::string> names;  ///< with their dashes; of a positional its bare name
  std::string description;
  std::vector<std::string> choices;  ///< the words that it takes; empty: others
  bool positional = false;
  bool takes_value = false;
};

/// The options of a command (or of the program itself) in their order.
std::vector<OptionText> options_of(const CLI::App& app);

/// Every command of the program in the order of `--help`.
std::vector<const CLI::App*> commands_of(const CLI::App& program);

}  // namespace carillon::cli
