#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cli/build/samples_task.hpp"

namespace carillon::cli {

/// Makes samples of one shape with every column that their shard stores.
class SampleRows {
 public:
  /// @param trace  must outlive the rows, as config and shape must
  /// @throws FileError  the modes file is missing or damaged
  SampleRows(const BuildConfig& config, const Shape& shape, const BuildFolders& folders,
             core::Trace& trace);
  /// Adds one sample's row.
  SampleResult add(const Sample& sample, Columns& columns);

 private:
  const BuildConfig& config_;
  const Shape& shape_;
  core::Trace& trace_;
  SampleMaker maker_;
  std::vector<std::string> damping_units_;
  std::unique_ptr<synth::MelSpectrogram> mel_;
};

}  // namespace carillon::cli
