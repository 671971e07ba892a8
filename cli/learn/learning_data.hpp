#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/evaluate/datasets.hpp"
#include "eval/learning/sample_source.hpp"

namespace carillon::cli {

/// Samples that a configuration trains with: those of its own datasets, which are built first, or
/// with a key `data` those of a dataset's folder that is there.
class LearningData {
 public:
  /// One source, and what it is called in a folder of several.
  struct Named {
    std::string name;  ///< "" where there is one alone
    std::filesystem::path folder;
  };

  /// Reads the configuration, and plans datasets that are its own.
  /// @throws ConfigError, InputError, FileError  on every rank alike
  /// @note Collective on world.
  LearningData(const BuildOptions& options, MPI_Comm world);

  /// Builds what is not there yet.
  /// @return exit code of `carillon build`
  /// @note Collective on the context's world.
  int build(const Context& context) const;

  const std::filesystem::path& output() const { return output_; }
  const std::vector<Named>& sources() const { return sources_; }

 private:
  std::optional<EvaluatedDatasets> datasets_;
  std::filesystem::path output_;
  std::vector<Named> sources_;
};

/// Holds a dataset's splits against what is stored: no body in two parts, no strike, no room, no
/// stretch of noise (`carillon check`).
/// @param split  column that is learnt by
/// @throws InputError  a leak; says which
void require_clean_split(const std::filesystem::path& folder, const std::string& split);

}  // namespace carillon::cli
