#include "eval/studies/learning/run_trainings.hpp"

namespace carillon::eval::studies {

std::filesystem::path models_folder(const EvaluatedDatasets& datasets) {
  return datasets.output() / "evaluation" / "models";
}

TrainingsEnd run_trainings(const LearningConfig& config, std::span<const std::uint64_t> seeds,
                           std::span<const LearningSource> sources,
                           const std::filesystem::path& models, MPI_Comm world) {
  TrainingsEnd end;
  for (std::size_t s = 0; s < sources.size(); ++s) {
    const LearningSource& source = sources[s];
    for (const learning::TaskSpec& task : config.tasks) {
      for (const learning::Method& unseeded : config.methods) {
        for (const learning::Method& method : with_seeds(unseeded, seeds)) {
          TrainingJob job = make_job(*source.samples, task, method, models / source.place);
          if (!source.place.empty()) job.key = source.place + "/" + job.key;
          JobEnd ended = run_job(job, *source.samples, world);
          if (ended.interrupted) {
            end.interrupted = true;
            return end;
          }
          end.trained.push_back({s, std::move(job), ended.was_there, std::move(ended.record)});
        }
      }
    }
  }
  return end;
}

}  // namespace carillon::eval::studies
