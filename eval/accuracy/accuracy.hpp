#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "eval/accuracy/accuracy_config.hpp"
#include "mpi/context.hpp"

namespace carillon::eval::accuracy {

struct AccuracyOptions {
  std::string config;
  std::string output;  ///< folder; "": the configuration's name
  std::vector<std::string> overrides;
};

/// Measures the study of a configuration: on rank 0 while the others wait, or on all ranks.
/// What is known is rewritten as accuracy.json after each body, so that a study that is cut short
/// keeps what it measured. A body that fails does not spoil the others.
/// @param output  folder that exists, for accuracy.json and stand-ins
/// @return the document of accuracy.json, the same on every rank that measures
/// @note Collective on the context's world.
nlohmann::json measure_accuracy(const AccuracyConfig& config, const std::filesystem::path& output,
                                const mpi::Context& context);

}  // namespace carillon::eval::accuracy
