#pragma once

#include <filesystem>
#include <functional>
#include <span>

#include "cli/context.hpp"
#include "cli/evaluate/datasets.hpp"
#include "core/config.hpp"

namespace carillon::cli {

/// Runs what a section asks for on datasets that are built, and keeps what it finds.
/// @param folder  `evaluation` of the output, which exists and is locked by this run
/// @return exit code, the same on every rank
/// @note Collective on the context's world.
using RunEvaluation =
    std::function<int(const std::filesystem::path& folder, const Context& context)>;

/// One section of `evaluate:`: a question that is put to datasets.
struct EvaluationSection {
  const char* name;
  /// Reads the section before anything is built; what it returns runs afterwards.
  /// @param datasets  planned; outlives what is returned
  /// @throws ConfigError
  RunEvaluation (*read)(core::ConfigNode& node, const EvaluatedDatasets& datasets);
};

/// Every section that there is. A new one is a file and a line of evaluate_command.cpp.
std::span<const EvaluationSection> evaluation_sections();

/// `damping`: are damping parameters found again? (docs/damping-validation.md)
RunEvaluation read_damping_validation(core::ConfigNode& node, const EvaluatedDatasets& datasets);

}  // namespace carillon::cli
