#include "eval/studies/learning/learning_sources.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <map>
#include <set>

#include "core/error.hpp"
#include "eval/learning/dataset_source.hpp"
#include "eval/learning/recordings_source.hpp"
#include "eval/learning/selected_source.hpp"
#include "eval/scoring/clean_split.hpp"
#include "mpi/comm.hpp"

namespace carillon::eval::studies {

namespace {

std::set<std::string> splits_of(const LearningConfig& config) {
  std::set<std::string> splits;
  for (const learning::TaskSpec& task : config.tasks) splits.insert(task.split);
  return splits;
}

LearningSource join(std::vector<std::unique_ptr<learning::SampleSource>> sources,
                    std::vector<std::string> names) {
  std::vector<learning::SampleSource*> all;
  std::vector<learning::Selection> selected;
  for (std::size_t s = 0; s < sources.size(); ++s) {
    all.push_back(sources[s].get());
    for (std::size_t row = 0; row < sources[s]->size(); ++row) {
      selected.push_back({static_cast<std::uint32_t>(s), static_cast<std::uint32_t>(row)});
    }
  }
  LearningSource joined{"joined", "joined",
                        learning::select_samples(all, std::move(selected), std::move(names)),
                        std::move(sources)};
  return joined;
}

}  // namespace

void require_one_part(const std::vector<const learning::SampleSource*>& sources,
                      const std::string& split) {
  std::map<std::string, std::string> part_of;
  for (const learning::SampleSource* source : sources) {
    const std::vector<std::string> names =
        split == "split_shape" ? source->object_names() : source->strike_names();
    const std::vector<std::string> keys = source->keys();
    const std::vector<std::string> parts = source->labels(split);
    for (std::size_t i = 0; i < names.size(); ++i) {
      const auto [at, fresh] = part_of.emplace(names[i], parts[i]);
      if (fresh || at->second == parts[i]) continue;
      throw core::InputError(
          fmt::format("{}: {}: the same {} is in {} here and in {} of another source",
                      source->name(), keys[i], split == "split_shape" ? "object" : "strike",
                      parts[i], at->second),
          "what is learnt from one would be tested in the other: give both one seed and one split");
    }
  }
}

std::unique_ptr<learning::SampleSource> open_source(
    const Condition& condition, const LearningConfig& config, const std::filesystem::path& cache,
    MPI_Comm world, const std::optional<learning::ClipFormat>& format) {
  std::unique_ptr<learning::SampleSource> source;
  if (condition.recordings) {
    // Their splits are checked where they are asked for.
    mpi::agreed(world, [&] { source = learning::open_recordings(*condition.recordings, format); });
    if (mpi::rank(world) == 0 && splits_of(config).count("split_shape") > 0 &&
        source->object_names() == source->strike_names()) {
      spdlog::warn(
          "{}: every sound counts as an object of its own, so one object may be learnt from and "
          "tested: "
          "name the column of objects in recordings.object_column",
          source->name());
    }
    return source;
  }
  mpi::agreed(world, [&] {
    if (mpi::rank(world) != 0) return;
    for (const std::string& split : splits_of(config))
      scoring::require_clean_split(condition.folder, split, cache);
  });
  mpi::agreed(world,
              [&] { source = learning::open_dataset_source(condition.folder, config.listener); });
  return source;
}

std::vector<LearningSource> open_learning_sources(const LearningConfig& config,
                                                  const EvaluatedDatasets& datasets,
                                                  MPI_Comm world) {
  std::vector<LearningSource> sources;
  // Recordings are clipped as the sounds are of the dataset that is beside them.
  std::unique_ptr<learning::SampleSource> with;
  std::optional<learning::ClipFormat> format;
  if (config.with && !config.with->recordings) {
    with = open_source(*config.with, config, datasets.cache(), world);
    format = with->clip_format();
  }
  for (const Condition& condition : datasets.conditions()) {
    sources.push_back({condition.name, condition.place,
                       open_source(condition, config, datasets.cache(), world, format)});
  }
  if (!config.join && !config.with) return sources;
  if (config.with && !with) {
    with = open_source(*config.with, config, datasets.cache(), world,
                       sources.front().samples->clip_format());
  }
  std::vector<std::unique_ptr<learning::SampleSource>> parts;
  std::vector<const learning::SampleSource*> all;
  std::vector<std::string> names;
  for (std::size_t c = 0; c < sources.size(); ++c) {
    names.push_back(sources[c].name);
    parts.push_back(std::move(sources[c].samples));
  }
  if (config.with) {
    names.push_back(config.with->name);
    parts.push_back(std::move(with));
  }
  mpi::agreed(world, [&] {
    for (const auto& part : parts) all.push_back(part.get());
    for (const std::string& split : splits_of(config)) require_one_part(all, split);
    sources.clear();
    sources.push_back(join(std::move(parts), std::move(names)));
  });
  return sources;
}

}  // namespace carillon::eval::studies
