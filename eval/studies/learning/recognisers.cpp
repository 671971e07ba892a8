#include "eval/studies/learning/recognisers.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "core/error.hpp"
#include "eval/studies/learning/trainings.hpp"

namespace carillon::eval::studies {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using nlohmann::ordered_json;

double rank_of(const json& record) {
  const json& accuracy = record.at("validation_accuracy");
  return accuracy.is_null() ? -1.0 : accuracy.get<double>();
}

networks::Learner load_learner(const fs::path& folder) {
  json notes;
  return networks::Learner::load(folder / "model", notes);
}

}  // namespace

Recogniser::Recogniser(const fs::path& folder) : Recogniser(folder, read_record(folder)) {}

Recogniser::Recogniser(const fs::path& folder, const ordered_json& record)
    : folder_(folder),
      task_(record.at("task").at("name")),
      column_(record.at("task").at("column")),
      labels_(record.at("task").at("classes")),
      source_(record.at("source_folder").get<std::string>()),
      learner_(load_learner(folder)),
      recognition_(recognition::load_recognition(folder / "recognition")),
      validation_accuracy_(rank_of(record)),
      measured_({{"accuracy", record.at("test_accuracy")},
                 {"samples", record.at("samples").at("test")},
                 {"calibrated", record.at("samples").at("validation") > 0},
                 {"recognition", record.at("recognition")}}),
      preparer_(recognition_.format) {}

std::string Recogniser::label_of(const std::string& name) const {
  const auto found = labels_.find(name);
  return found == labels_.end() ? name : found->second.front();
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
  double accuracy = 0;
  json record;

  /// What must be alike for accuracies to be compared.
  json comparable() const {
    return {record.at("source_content"), record.at("task"), record.at("classes")};
  }
};

bool is_asked(const json& record, const std::string& method,
              const std::vector<std::string>& tasks) {
  const std::string task = record.at("task").at("name");
  return (method.empty() || record.at("method").at("name") == method) &&
         (tasks.empty() || std::find(tasks.begin(), tasks.end(), task) != tasks.end());
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
    const json record = read_record(training);
    if (!is_asked(record, method, tasks)) continue;
    found.push_back(
        {training, fs::last_write_time(training / "training.json"), rank_of(record), record});
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
    if (one->record.at("source") != newest->record.at("source")) {
      throw core::InputError(
          fmt::format("networks of the task {} learnt from several sources: {} and {}",
                      newest->record.at("task").at("name").get<std::string>(),
                      newest->folder.string(), one->folder.string()),
          "give --models the folder of one of them");
    }
    if (one->comparable() == newest->comparable() && one->accuracy > best->accuracy) best = one;
  }
  return *best;
}

}  // namespace

std::vector<Recogniser> find_recognisers(const fs::path& folder, const std::string& method,
                                         const std::vector<std::string>& tasks) {
  std::vector<Recogniser> recognisers;
  try {
    const std::vector<Candidate> found = find_candidates(folder, method, tasks);
    std::map<std::string, std::vector<const Candidate*>> by_task;
    for (const Candidate& one : found) {
      by_task[one.record.at("task").at("name")].push_back(&one);
    }
    for (const auto& [task, candidates] : by_task) {
      recognisers.emplace_back(best_of(candidates).folder);
    }
  } catch (const json::exception& error) {
    throw core::InputError(
        fmt::format("{}: a training.json of another make: {}", folder.string(), error.what()),
        "train again");
  }
  if (recognisers.empty()) {
    throw core::InputError(
        fmt::format("{}: no trained network{} that only hears{}", folder.string(),
                    method.empty() ? "" : fmt::format(" {}", method),
                    tasks.empty() ? "" : fmt::format(" of the task {}", fmt::join(tasks, " or "))),
        "give the output of carillon train with isnn-a, soundnet5 or soundnet8 among its methods");
  }
  return recognisers;
}

}  // namespace carillon::eval::studies
