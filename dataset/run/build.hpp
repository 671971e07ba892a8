#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "dataset/plan/plan.hpp"
#include "mpi/context.hpp"

namespace carillon::dataset::run {

struct BuildOptions {
  std::string config;                  ///< path of the YAML file
  std::string output;                  ///< "": a folder named as the configuration
  std::vector<std::string> overrides;  ///< --set key=value
  bool retry_failed = false;
  bool tell = true;  ///< on standard output, what came of it; a run that is cut short always does
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

/// What `carillon plan` tells of a build; docs/guide.md names the fields.
nlohmann::json describe_plan(const LoadedBuild& build);

/// Builds the dataset, or carries on where an earlier run of the same configuration stopped.
/// @return exit code
/// @note Collective on the context's world.
int run_build(const BuildOptions& options, const mpi::Context& context);
/// The same of a build that is loaded.
int run_build(LoadedBuild build, const BuildOptions& options, const mpi::Context& context);

}  // namespace carillon::dataset::run
