#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>

#include "core/config.hpp"
#include "eval/studies/datasets.hpp"
#include "mpi/exit_code.hpp"

namespace carillon::eval::studies {

/// How a section ended; the same on every rank.
struct EvaluationEnd {
  int exit_code = mpi::exit_done;
  nlohmann::ordered_json document{};  ///< for a program, on rank 0; null where it was interrupted
  std::string text{};                 ///< the same for a person
};

/// Runs what a section asks for on datasets that are built, and keeps what it finds.
/// @param folder  `evaluation` of the output, which exists and is locked by this run
/// @note Collective on world.
using RunEvaluation =
    std::function<EvaluationEnd(const std::filesystem::path& folder, MPI_Comm world)>;

/// One section of `evaluate:`: a question that is put to datasets.
struct EvaluationSection {
  const char* name;
  /// Reads the section before anything is built; what it returns runs afterwards.
  /// @param root      the configuration, where the section needs more of it
  /// @param datasets  planned; outlives what is returned
  /// @throws ConfigError
  RunEvaluation (*read)(core::ConfigNode& node, core::ConfigNode& root,
                        const EvaluatedDatasets& datasets);
  bool elsewhere = false;  ///< only carillon-learn, which then takes this program's place, has it
};

/// `damping`: are damping parameters found again? (docs/damping-validation.md)
RunEvaluation read_damping_validation(core::ConfigNode& node, core::ConfigNode& root,
                                      const EvaluatedDatasets& datasets);

/// Writes what a section says of its own work (`trace`: times and counts).
/// @param made    of mpi::made_by()
/// @param worked  whether this run did any of it; an earlier run's file is left alone otherwise
void keep_evaluation_trace(const std::filesystem::path& path, bool worked,
                           nlohmann::ordered_json trace, nlohmann::ordered_json made);

}  // namespace carillon::eval::studies
