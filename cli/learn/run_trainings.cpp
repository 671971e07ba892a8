#include "cli/learn/run_trainings.hpp"

#include <set>

#include "cli/learn/clean_split.hpp"
#include "eval/learning/dataset_source.hpp"
#include "eval/learning/recordings_source.hpp"
#include "mpi/comm.hpp"

namespace carillon::cli {

std::unique_ptr<eval::SampleSource> open_source(const Condition& condition,
                                                const LearningConfig& config,
                                                const Context& context) {
  std::unique_ptr<eval::SampleSource> source;
  if (condition.recordings) {
    // Their splits are checked where they are asked for.
    mpi::agreed(context.world, [&] { source = eval::open_recordings(*condition.recordings); });
    return source;
  }
  mpi::agreed(context.world, [&] {
    std::set<std::string> splits;
    for (const eval::TaskSpec& task : config.tasks) splits.insert(task.split);
    if (!context.speaks()) return;
    for (const std::string& split : splits) require_clean_split(condition.folder, split);
  });
  mpi::agreed(context.world,
              [&] { source = eval::open_dataset_source(condition.folder, config.listener); });
  return source;
}

TrainingsEnd run_trainings(const LearningConfig& config, std::span<const std::uint64_t> seeds,
                           const EvaluatedDatasets& datasets, const Context& context) {
  const std::filesystem::path models = datasets.output() / "evaluation" / "models";
  TrainingsEnd end;
  for (std::size_t c = 0; c < datasets.conditions().size(); ++c) {
    const Condition& condition = datasets.conditions()[c];
    const auto source = open_source(condition, config, context);
    for (const eval::TaskSpec& task : config.tasks) {
      for (eval::Method method : config.methods) {
        const bool seeded = method.kind != eval::MethodKind::nearest_neighbour;
        for (const std::uint64_t seed : seeded ? seeds : seeds.first(1)) {
          method.learning.seed = seed;
          TrainingJob job = make_job(*source, task, method, models / condition.place);
          if (!condition.place.empty()) job.key = condition.place + "/" + job.key;
          JobEnd ended = run_job(job, *source, context);
          if (ended.interrupted) {
            end.interrupted = true;
            return end;
          }
          end.trained.push_back({c, std::move(job), ended.was_there, std::move(ended.found)});
        }
      }
    }
  }
  return end;
}

}  // namespace carillon::cli
