#pragma once

#include <mpi.h>

#include <optional>
#include <string>
#include <vector>

#include "core/tell.hpp"
#include "dataset/plan/plan.hpp"

namespace carillon::dataset::run {

struct BuildOptions {
  std::string config;                  ///< path of the YAML file, or what `text` is called
  std::string output;                  ///< "": a folder named as the configuration
  std::vector<std::string> overrides;  ///< --set key=value
  bool retry_failed = false;
  std::optional<std::string> text{};  ///< of a configuration that is no file
  std::string cache{};                ///< folder of meshes and modes; empty: none is kept
  std::string command{};              ///< as it was typed, for trace.json
  core::Tell tell{};                  ///< what came of it; may be empty
  core::Tell tell_interrupted{};      ///< the same of a run that is cut short
};

/// A configuration as every rank sees it, and what it expands to.
struct LoadedBuild {
  std::string path;                    ///< of the configuration
  std::vector<std::string> overrides;  ///< --set
  configuration::BuildConfig config;
  plan::BuildPlan plan;
};

/// The text of a configuration, read on rank 0.
/// @throws FileError  on every rank alike
/// @note Collective on world.
std::string shared_text(const std::string& path, MPI_Comm world);
/// The same, or the one that is given.
std::string shared_text(const BuildOptions& options, MPI_Comm world);

/// What a configuration's text says with these overrides; the plan is still empty.
/// @throws ConfigError, InputError, FileError
LoadedBuild read_build(const std::string& text, const BuildOptions& options);

/// Refuses to go on where ranks do not see the same files.
/// @throws InputError  on every rank alike
/// @note Collective on world.
void check_alike(const std::string& fingerprint, MPI_Comm world);

/// Reads on rank 0, broadcasts the text, shares the reading of mesh files, plans on every rank and
/// compares.
/// @throws ConfigError, InputError, FileError  on every rank alike
/// @note Collective on world.
LoadedBuild load_build(const BuildOptions& options, MPI_Comm world);

/// Builds the dataset, or carries on where an earlier run of the same configuration stopped.
/// @return exit code
/// @note Collective on world.
int run_build(LoadedBuild build, const BuildOptions& options, MPI_Comm world);

}  // namespace carillon::dataset::run
