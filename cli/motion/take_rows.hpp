#pragma once

#include <memory>

#include "cli/build/samples_task.hpp"
#include "cli/motion/take_maker.hpp"

namespace carillon::cli {

/// Makes takes with every column that their shard stores.
class TakeRows {
 public:
  /// @param trace  must outlive the rows, as config and plan must
  TakeRows(const BuildConfig& config, const BuildPlan& plan, const BuildFolders& folders,
           core::Trace& trace);
  /// Adds one take's row.
  SampleResult add(const Sample& sample, Columns& columns);

 private:
  const BuildConfig& config_;
  const BuildPlan& plan_;
  core::Trace& trace_;
  TakeMaker maker_;
  std::unique_ptr<synth::MelSpectrogram> mel_;
};

/// Files of a take's movie that an earlier run wrote, relative to the output folder.
std::vector<std::string> movie_files(const Sample& sample, const BuildFolders& folders);

/// Writes the frames of a take, and joins them with its sound to a movie where ffmpeg is there.
/// @return paths of the files, relative to the output folder
std::vector<std::string> write_movie(const BuildConfig& config, const Sample& sample,
                                     const SampleResult& result, const BuildFolders& folders);

}  // namespace carillon::cli
