#pragma once

#include <cstddef>
#include <vector>

#include "core/config.hpp"
#include "eval/learning/method.hpp"
#include "eval/learning/task.hpp"

namespace carillon::cli {

/// What the section `train` asks for: every method learns every task.
struct LearningConfig {
  std::vector<eval::TaskSpec> tasks;
  std::vector<eval::Method> methods;  ///< their seed is that of the section
  std::size_t listener = 0;
};

/// The section `train` of a configuration.
/// @throws ConfigError  it is missing, or wrong
LearningConfig read_train_section(core::ConfigNode& root);

}  // namespace carillon::cli
