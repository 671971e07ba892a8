#include "eval/studies/learning/recognisers.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "core/error.hpp"
#include "core/what_is.hpp"

namespace carillon::eval::studies {

namespace fs = std::filesystem;

double validation_rank(const TrainingRecord& record) {
  return std::isnan(record.validation_accuracy) ? -1.0 : record.validation_accuracy;
}

Recogniser::Recogniser(const fs::path& folder, learning::Device device)
    : folder_(folder),
      record_(read_record(folder)),
      learner_(networks::Learner::load(folder / "model", device)),
      recognition_(recognition::load_recognition(folder / "recognition")),
      preparer_(recognition_.format) {}

std::string Recogniser::label_of(const std::string& name) const {
  const auto found = record_.task.classes.find(name);
  return found == record_.task.classes.end() ? name : found->second.front();
}

recognition::Recognised Recogniser::operator()(const core::AudioClip& recording) const {
  return recognition::recognise(learner_, recognition_, preparer_,
                                learning::strike_clip(recording, recognition_.format));
}

namespace {

/// A training that can answer for single sounds.
struct Candidate {
  fs::path folder;
  fs::file_time_type made;
  TrainingRecord record;

  /// What must be alike for accuracies to be compared.
  auto comparable() const { return std::tie(record.source_content, record.task, record.classes); }
};

bool is_asked(const TrainingRecord& record, const std::string& method,
              const std::vector<std::string>& tasks) {
  return (method.empty() || record.method.name == method) &&
         (tasks.empty() || std::find(tasks.begin(), tasks.end(), record.task.name) != tasks.end());
}

std::vector<Candidate> find_candidates(const fs::path& folder, const std::string& method,
                                       const std::vector<std::string>& tasks) {
  std::vector<Candidate> found;
  std::error_code error;
  for (fs::recursive_directory_iterator at(folder, error), end; !error && at != end;
       at.increment(error)) {
    const fs::path training = at->path().parent_path();
    // What is written last is not there yet where a training is on its way.
    if (at->path().filename() != "recognition" || !fs::exists(training / "training.json")) continue;
    TrainingRecord record = read_record(training);
    if (!is_asked(record, method, tasks)) continue;
    found.push_back({training, fs::last_write_time(training / "training.json"), std::move(record)});
  }
  if (error) throw core::FileError(fmt::format("{}: {}", folder.string(), error.message()));
  std::sort(found.begin(), found.end(),
            [](const Candidate& a, const Candidate& b) { return a.folder < b.folder; });
  return found;
}

/// The best of those that learnt the same as the newest one.
/// @throws InputError  others learnt from another source
const Candidate& best_of(const std::vector<const Candidate*>& candidates) {
  const Candidate* newest =
      *std::max_element(candidates.begin(), candidates.end(),
                        [](const Candidate* a, const Candidate* b) { return a->made < b->made; });
  const Candidate* best = newest;
  for (const Candidate* one : candidates) {
    if (one->record.source != newest->record.source) {
      throw core::InputError(
          fmt::format("networks of the task {} learnt from several sources: {} and {}",
                      newest->record.task.name, newest->folder.string(), one->folder.string()),
          "give --models the folder of one of them");
    }
    if (one->comparable() == newest->comparable() &&
        validation_rank(one->record) > validation_rank(best->record)) {
      best = one;
    }
  }
  return *best;
}

}  // namespace

std::vector<Recogniser> find_recognisers(const fs::path& folder, const std::string& method,
                                         const std::vector<std::string>& tasks,
                                         learning::Device device) {
  std::vector<Recogniser> recognisers;
  const std::vector<Candidate> found = find_candidates(folder, method, tasks);
  std::map<std::string, std::vector<const Candidate*>> by_task;
  for (const Candidate& one : found) by_task[one.record.task.name].push_back(&one);
  for (const auto& [task, candidates] : by_task) {
    recognisers.emplace_back(best_of(candidates).folder, device);
  }
  if (recognisers.empty()) {
    const core::WhatIs what = core::what_is(folder);
    const bool trained = what.name == "a folder of trained classifiers" || what.name == "a folder";
    throw core::InputError(
        fmt::format("{}{}: no trained network{} that only hears{}", folder.string(),
                    trained ? "" : " is " + what.name,
                    method.empty() ? "" : fmt::format(" {}", method),
                    tasks.empty() ? "" : fmt::format(" of the task {}", fmt::join(tasks, " or "))),
        "give the output of carillon train with isnn-a, soundnet5 or soundnet8 among its methods");
  }
  return recognisers;
}

}  // namespace carillon::eval::studies
