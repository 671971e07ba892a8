#pragma once

#include <mpi.h>

#include <filesystem>
#include <string>

#include "eval/studies/learning/training_record.hpp"

namespace carillon::eval::studies {

/// One classifier that learns one task from one source.
struct TrainingJob {
  std::string key;  ///< for people: geometry/isnn-a/seed-1
  learning::TaskSpec task;
  learning::Method method;
  std::filesystem::path folder;  ///< ends with a hash of all that decides the result
  std::string inputs;            ///< that hash
  bool is_for_use = true;        ///< it may be asked for single sounds: `recognition` is kept
};

/// @param models  folder of all trainings
TrainingJob make_job(const learning::SampleSource& source, const learning::TaskSpec& task,
                     const learning::Method& method, const std::filesystem::path& models);

/// How a job ended; the same on every rank.
struct JobEnd {
  bool interrupted = false;
  bool was_there = false;  ///< an earlier run had finished it
  TrainingRecord record;
};

/// Trains, answers for the parts that were held out and keeps in the job's folder: `model`,
/// `checkpoint` while it goes on, `curves.csv`, `answers.h5`, `recognition` of a network that only
/// hears, and `training.json`, which is written last. What is there is not made again.
/// @throws InputError, FileError  on every rank alike
/// @note Collective on world.
JobEnd run_job(const TrainingJob& job, learning::SampleSource& source, MPI_Comm world);

}  // namespace carillon::eval::studies
