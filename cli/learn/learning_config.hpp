#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "cli/evaluate/datasets.hpp"
#include "core/config.hpp"
#include "eval/learning/method.hpp"
#include "eval/learning/task.hpp"

namespace carillon::cli {

/// What the section `train` asks for: every method learns every task.
struct LearningConfig {
  std::vector<eval::TaskSpec> tasks;
  std::vector<eval::Method> methods;  ///< their seed is that of the section
  std::size_t listener = 0;
  bool join = false;              ///< all datasets as one
  std::optional<Condition> with;  ///< joined with these
};

/// The section `train` of a configuration.
/// @param file  its name, which paths are meant from
/// @throws ConfigError  it is missing, or wrong
LearningConfig read_train_section(core::ConfigNode& root, const std::string& file);

}  // namespace carillon::cli
