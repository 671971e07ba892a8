#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "eval/learning/sample_source.hpp"
#include "eval/studies/datasets.hpp"
#include "eval/studies/learning/learning_config.hpp"

namespace carillon::eval::studies {

/// What classifiers learn from: a dataset, recordings, or several of them as one.
struct LearningSource {
  std::string name;
  std::string place;  ///< folder of its models among those of the others; "" where it is alone
  std::unique_ptr<learning::SampleSource> samples;
  std::vector<std::unique_ptr<learning::SampleSource>> joined_from{};
};

/// A dataset whose splits hold what they promise, or recordings.
/// @param cache   as of scoring::require_clean_split()
/// @param format  of recordings' clips, where they stand beside a dataset's sounds
/// @throws InputError, FileError  a split that leaks, no dataset; on every rank alike
/// @note Collective on world.
std::unique_ptr<learning::SampleSource> open_source(
    const Condition& condition, const LearningConfig& config, const std::filesystem::path& cache,
    MPI_Comm world, const std::optional<learning::ClipFormat>& format = {});

/// Refuses sources that have a sound, or an object where objects are held out, in different parts.
/// @throws InputError  names it
void require_one_part(const std::vector<const learning::SampleSource*>& sources,
                      const std::string& split);

/// Every dataset of a configuration that is built, or with `train.join` or `train.with` all of them
/// as one, whose column `dataset` says which each sample is of.
/// @throws InputError, FileError  as open_source(); joined ones of a sweep that have a strike or an
///                                object in two parts
/// @note Collective on world.
std::vector<LearningSource> open_learning_sources(const LearningConfig& config,
                                                  const EvaluatedDatasets& datasets,
                                                  MPI_Comm world);

}  // namespace carillon::eval::studies
