#pragma once

#include <mpi.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "eval/accuracy/findings.hpp"

namespace carillon::eval::accuracy {

struct AccuracyOptions {
  std::string config;
  std::string output;  ///< folder; "": the configuration's name
  std::vector<std::string> overrides;
  std::string cache{};    ///< folder of meshes and modes; empty: none is kept
  std::string command{};  ///< as it was typed, for accuracy.json
};

/// What was measured.
struct StudyFindings {
  std::optional<SoundFindings> sound;
  std::optional<FeatureFindings> features;
  std::vector<Findings> objects;
  nlohmann::json document;  ///< accuracy.json
};

/// Whether something could not be measured.
bool has_failed(const StudyFindings& findings);

/// Tables for a person.
void print(const StudyFindings& findings);

/// Measures the study of a configuration: on rank 0 while the others wait, or on all ranks.
/// What is known is rewritten as accuracy.json after each object, so that a study that is cut short
/// keeps what it measured. An object that fails does not spoil the others.
/// @param output  folder that exists, for accuracy.json and stand-ins
/// @return the same on every rank that measures; nothing on others
/// @note Collective on world.
StudyFindings measure_accuracy(const AccuracyConfig& config, const std::filesystem::path& output,
                               const AccuracyOptions& options, MPI_Comm world);

}  // namespace carillon::eval::accuracy
