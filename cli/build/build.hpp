#pragma once

#include <string>
#include <vector>

#include "cli/build/plan.hpp"
#include "cli/context.hpp"

namespace carillon::cli {

struct BuildOptions {
  std::string config;                  ///< path of the YAML file
  std::string output;                  ///< "": a folder named as the configuration
  std::vector<std::string> overrides;  ///< --set key=value
  bool retry_failed = false;
};

/// A configuration as every rank sees it, and what it expands to.
struct LoadedBuild {
  std::string path;                    ///< of the configuration
  std::vector<std::string> overrides;  ///< --set
  BuildConfig config;
  BuildPlan plan;
};

/// Reads on rank 0, broadcasts the text, expands on every rank and compares.
/// @throws ConfigError, InputError, FileError  on every rank alike
/// @note Collective on world.
LoadedBuild load_build(const BuildOptions& options, MPI_Comm world);

/// Builds the dataset, or carries on where an earlier run of the same configuration stopped.
/// @return exit code
/// @note Collective on the context's world.
int run_build(const BuildOptions& options, const Context& context);

}  // namespace carillon::cli
