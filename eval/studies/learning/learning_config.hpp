#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/config.hpp"
#include "eval/learning/method.hpp"
#include "eval/learning/task.hpp"
#include "eval/studies/datasets.hpp"

namespace carillon::eval::studies {

/// What the section `train` asks for: every method learns every task.
struct LearningConfig {
  std::vector<learning::TaskSpec> tasks;
  std::vector<learning::Method> methods;  ///< their seed is that of the section
  std::size_t listener = 0;
  bool join = false;              ///< all datasets as one
  std::optional<Condition> with;  ///< joined with these
};

/// The section `train` of a configuration.
/// @param file  its name, which paths are meant from
/// @throws ConfigError  it is missing, or wrong
LearningConfig read_train_section(core::ConfigNode& root, const std::string& file);

/// The key `seeds` of a section of `evaluate`: by default the one of the section `train`.
/// @throws ConfigError  one that is no whole number from 0 on, one twice, or none
std::vector<std::uint64_t> read_seeds(core::ConfigNode& node, const LearningConfig& learning);

/// The method with each seed; neighbours are the same for all: with the first.
std::vector<learning::Method> with_seeds(const learning::Method& method,
                                         std::span<const std::uint64_t> seeds);

}  // namespace carillon::eval::studies
