#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "report/service/jobs/job.hpp"

namespace carillon::report::service {

/// How a job's ranks are started.
enum class Launcher { mpirun, slurm };

/// How a process of a job stands.
struct JobProcess {
  bool runs = true;              ///< or waits for Slurm to start it
  bool waits = false;            ///< for Slurm
  std::optional<int> exit_code;  ///< of one that runs no more; nothing: it ended without a word
};

/// Starts a job's command in its folder: by itself for one rank, else by mpirun; other than scores
/// as a job of Slurm's (scripts/slurm/job.sbatch) where that is asked for. The process outlives the
/// service, and notes its own exit code.
/// @param program  carillon
/// @return what find_process() knows it by: {"pid", "began"} or {"slurm"}
/// @throws StorageError  it cannot be started
nlohmann::json start_process(const std::filesystem::path& folder, const Job& job, Launcher launcher,
                             const std::filesystem::path& program);

/// @param process  of this service or an earlier one
JobProcess find_process(const std::filesystem::path& folder, const nlohmann::json& process);

/// Asks it to stop, as Ctrl-C does; a build keeps what it has done.
/// @param by_force  at once
void stop_process(const nlohmann::json& process, bool by_force);

}  // namespace carillon::report::service
