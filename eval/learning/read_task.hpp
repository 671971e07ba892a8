#pragma once

#include <string>

#include "core/config.hpp"
#include "eval/learning/task.hpp"

namespace carillon::eval::learning {

/// A task of `train.tasks` (docs/learning.md).
/// @throws ConfigError  no column, or keys that do not go together
TaskSpec read_task(core::ConfigNode& node, const std::string& name);

}  // namespace carillon::eval::learning
