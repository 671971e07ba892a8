#include "cli/learn/recognisers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "core/error.hpp"
#include "core/files.hpp"

namespace carillon::cli {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json read_record(const fs::path& folder) {
  try {
    return json::parse(core::read_file(folder / "training.json"));
  } catch (const json::exception& error) {
    throw core::InputError(fmt::format("{}: {}", (folder / "training.json").string(), error.what()),
                           "delete the folder, and train again");
  }
}

eval::Learner load_learner(const fs::path& folder) {
  json notes;
  return eval::Learner::load(folder / "model", notes);
}

}  // namespace

Recogniser::Recogniser(const fs::path& folder) : Recogniser(folder, read_record(folder)) {}

Recogniser::Recogniser(const fs::path& folder, json notes)
    : folder_(folder),
      task_(notes.at("task").at("name")),
      column_(notes.at("task").at("column")),
      labels_(notes.at("task").at("classes")),
      source_(notes.at("source").get<std::string>()),
      learner_(load_learner(folder)),
      recognition_(eval::load_recognition(folder / "recognition")),
      preparer_(recognition_.format) {}

std::string Recogniser::label_of(const std::string& name) const {
  const auto found = labels_.find(name);
  return found == labels_.end() ? name : found->second.front();
}

eval::Recognised Recogniser::operator()(const core::AudioClip& recording) const {
  return eval::recognise(learner_, recognition_, preparer_,
                         eval::strike_clip(recording, recognition_.format));
}

std::vector<Recogniser> find_recognisers(const fs::path& folder, const std::string& method) {
  struct Best {
    fs::path folder;
    double accuracy = 0;
  };
  std::map<std::string, Best> best;  // by task
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::recursive_directory_iterator at(folder, error), end; !error && at != end;
       at.increment(error)) {
    if (at->path().filename() == "recognition") found.push_back(at->path().parent_path());
  }
  if (error) throw core::FileError(fmt::format("{}: {}", folder.string(), error.message()));
  std::sort(found.begin(), found.end());
  for (const fs::path& training : found) {
    const json record = read_record(training);
    if (!method.empty() && record.at("method").at("name") != method) continue;
    const json& accuracy = record.at("validation_accuracy");
    const Best candidate{training, accuracy.is_null() ? -1.0 : accuracy.get<double>()};
    const auto [at, fresh] = best.emplace(record.at("task").at("name"), candidate);
    if (!fresh && candidate.accuracy > at->second.accuracy) at->second = candidate;
  }
  if (best.empty()) {
    throw core::InputError(
        fmt::format("{}: no trained network{} that only hears", folder.string(),
                    method.empty() ? "" : fmt::format(" {}", method)),
        "give the output of carillon train with isnn-a, soundnet5 or soundnet8 among its methods");
  }
  std::vector<Recogniser> recognisers;
  for (const auto& [task, one] : best) recognisers.emplace_back(one.folder);
  return recognisers;
}

}  // namespace carillon::cli
