#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "dataset/samples/samples_task.hpp"

namespace carillon::dataset::samples {

/// The columns of a sound: audio, gain, peak, clipped, and mel where the build has it.
/// @param mel  null: none
void add_sound_columns(const configuration::BuildConfig& config, const SampleResult& result,
                       const synth::signal::MelSpectrogram* mel, core::Trace& trace,
                       core::Columns& columns);

/// Adds one sample's row, with every column that its shard stores.
using AddRow = std::function<SampleResult(const plan::Sample&, core::Columns&)>;

/// Of the samples of a task that have this shape, or of simulations. All must outlive it.
/// @throws FileError  a modes file is missing or damaged
AddRow row_maker(const configuration::BuildConfig& config, const plan::BuildPlan& plan,
                 std::size_t shape, const BuildFolders& folders, core::Trace& trace);

/// Makes samples of one shape with every column that their shard stores.
class SampleRows {
 public:
  /// @param trace  must outlive the rows, as config and shape must
  /// @throws FileError  the modes file is missing or damaged
  SampleRows(const configuration::BuildConfig& config, const plan::Shape& shape,
             const BuildFolders& folders, core::Trace& trace);
  /// Adds one sample's row.
  SampleResult add(const plan::Sample& sample, core::Columns& columns);

 private:
  const configuration::BuildConfig& config_;
  const plan::Shape& shape_;
  core::Trace& trace_;
  SampleMaker maker_;
  std::vector<std::string> damping_units_;
  std::unique_ptr<synth::signal::MelSpectrogram> mel_;
};

}  // namespace carillon::dataset::samples
