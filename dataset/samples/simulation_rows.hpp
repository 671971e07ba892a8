#pragma once

#include <memory>

#include "dataset/samples/samples_task.hpp"
#include "dataset/samples/simulation_maker.hpp"

namespace carillon::dataset::samples {

/// Makes simulations with every column that their shard stores.
class SimulationRows {
 public:
  /// @param trace  must outlive the rows, as config and plan must
  SimulationRows(const configuration::BuildConfig& config, const plan::BuildPlan& plan,
                 const BuildFolders& folders, core::Trace& trace);
  /// Adds one simulation's row.
  SampleResult add(const plan::Sample& sample, core::Columns& columns);

 private:
  const configuration::BuildConfig& config_;
  const plan::BuildPlan& plan_;
  core::Trace& trace_;
  SimulationMaker maker_;
  std::unique_ptr<synth::signal::MelSpectrogram> mel_;
};

/// Files of a simulation's movie that an earlier run wrote, relative to the output folder.
std::vector<std::string> movie_files(const plan::Sample& sample, const BuildFolders& folders);

/// Writes the frames of a simulation, and joins them with its sound to a movie where ffmpeg is
/// there.
/// @return paths of the files, relative to the output folder
std::vector<std::string> write_movie(const configuration::BuildConfig& config,
                                     const plan::Sample& sample, const SampleResult& result,
                                     const BuildFolders& folders);

}  // namespace carillon::dataset::samples
