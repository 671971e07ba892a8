#include "dataset/check/folder.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"
#include "core/hash.hpp"
#include "core/hdf5.hpp"
#include "core/json.hpp"
#include "core/numbers.hpp"
#include "dataset/configuration/inputs.hpp"
#include "dataset/run/progress_so_far.hpp"
#include "dataset/samples/shape_modes.hpp"
#include "mpi/folder_lock.hpp"
#include "mpi/journal.hpp"

namespace carillon::dataset::check {

using nlohmann::json;
namespace fs = std::filesystem;

namespace {

/// By the journal, which is only read here: a build may be writing to it.
std::map<std::string, json> finished_by_journal(const fs::path& folder) {
  const fs::path path = folder / "journal.jsonl";
  if (!fs::is_regular_file(path)) return {};
  try {
    return run::finished_tasks(mpi::read_journal(path).entries);
  } catch (const core::FileError&) {
    return {};  // It is no part of what a dataset promises.
  }
}

/// failures.json, where it can be read and is JSON.
json read_list(const fs::path& path) {
  try {
    return core::read_json(path);
  } catch (const core::FileError&) {
    return nullptr;
  }
}

/// Nothing where it is no list of files.
std::optional<std::vector<run::ListedFile>> listed_files(const json& files) {
  const auto is_file = [](const json& file) {
    return file.is_object() && file.contains("path") && file.at("path").is_string() &&
           file.contains("sha256") && file.at("sha256").is_string() && file.contains("bytes") &&
           file.at("bytes").is_number_integer();
  };
  if (!files.is_array() || !std::all_of(files.begin(), files.end(), is_file)) return {};
  return files.get<std::vector<run::ListedFile>>();
}

std::optional<std::vector<run::ListedFile>> listed_files(
    const std::map<std::string, json>& finished) {
  json files = json::array();
  for (const auto& [task, entry] : finished) {
    for (const json& file : entry.value("files", json::array())) files.push_back(file);
  }
  return listed_files(files);
}

/// Opens with the configuration of dataset.json where the folder's own cannot be read.
stored::StoredDataset open_somehow(const fs::path& folder, const std::string& inputs,
                                   Finding& finding) {
  try {
    return stored::open_dataset(folder, inputs);
  } catch (const core::Error& error) {
    const fs::path description = folder / "dataset.json";
    if (!fs::is_regular_file(description)) throw;
    const json document = core::read_json(description);
    if (!document.is_object() || !document.contains("configuration")) throw;
    finding.verdict = Verdict::fail;
    finding.items.push_back(error.message());
    return stored::open_dataset(folder, inputs, document.at("configuration").get<std::string>());
  }
}

void compare_configuration(const DatasetFolder& folder, Finding& finding) {
  const stored::StoredDataset& dataset = folder.dataset;
  if (dataset.description.is_null()) {
    if (folder.building) return;
    finding.verdict = Verdict::fail;
    finding.items.push_back("dataset.json is not there, or is no JSON");
  } else {
    const std::string stored = dataset.description.value("configuration", "");
    // A comment follows the resolved keys.
    if (!dataset.configuration.starts_with(stored)) {
      finding.verdict = Verdict::fail;
      finding.items.push_back("configuration.yaml is not the configuration in dataset.json");
    }
  }
}

}  // namespace

std::string DatasetFolder::path_of(std::size_t task) const {
  return dataset.build.plan.tasks[task].key + ".h5";
}

DatasetFolder open_folder(const fs::path& path, const std::string& inputs) {
  DatasetFolder folder;
  Finding finding{"configuration", Verdict::pass, "", "", {}};
  folder.dataset = open_somehow(path, inputs, finding);
  folder.building = mpi::is_locked(path);
  compare_configuration(folder, finding);
  folder.finished = finished_by_journal(path);
  const json& description = folder.dataset.description;
  const auto by_journal = listed_files(folder.finished);
  if (auto files =
          listed_files(description.is_object() ? description.value("files", json()) : json())) {
    folder.listed = std::move(*files);
  } else if (by_journal) {
    folder.listed = *by_journal;
  }
  // While a build goes on, the journal is ahead of dataset.json.
  if (folder.building && by_journal && by_journal->size() > folder.listed.size()) {
    folder.listed = *by_journal;
  }
  if (finding.verdict == Verdict::fail) {
    finding.text = "what the dataset was built by cannot be trusted";
    finding.remedy = "run the build again into this folder, or restore the file";
  } else if (!folder.dataset.doubts.empty()) {
    finding.verdict = Verdict::note;
    finding.text = "configuration.yaml and dataset.json agree; not all inputs can be verified";
    finding.items = folder.dataset.doubts;
  } else {
    finding.text = "configuration.yaml, dataset.json and the inputs agree";
  }
  folder.findings.push_back(std::move(finding));
  folder.failures = read_list(path / "failures.json");
  const plan::BuildPlan& plan = folder.dataset.build.plan;
  for (std::size_t t = 0; t < plan.tasks.size(); ++t) {
    if (plan.tasks[t].kind != plan::TaskKind::samples) continue;
    const bool there = fs::is_regular_file(path / (plan.tasks[t].key + ".h5"));
    (there ? folder.present : folder.absent).push_back(t);
  }
  return folder;
}

namespace {

/// Tasks that failures.json explains: those that failed, and those left out because of them.
std::set<std::string> explained(const json& failures) {
  std::set<std::string> tasks;
  if (!failures.is_array()) return tasks;
  for (const json& failure : failures) {
    if (!failure.is_object()) continue;
    tasks.insert(failure.value("task", ""));
    for (const json& task : failure.value("skipped", json::array())) {
      if (task.is_string()) tasks.insert(task.get<std::string>());
    }
  }
  return tasks;
}

}  // namespace

Finding check_counts(const DatasetFolder& folder) {
  const plan::BuildPlan& plan = folder.dataset.build.plan;
  const std::set<std::string> known = explained(folder.failures);
  std::size_t stored = 0, failed = 0;
  for (const std::size_t t : folder.present) stored += plan.tasks[t].count;
  std::vector<std::string> items;
  for (const std::size_t t : folder.absent) {
    const plan::BuildTask& task = plan.tasks[t];
    if (known.contains(task.key)) {
      failed += task.count;
    } else {
      items.push_back(fmt::format("{}.h5 with {} samples is not there", task.key, task.count));
    }
  }
  const json& description = folder.dataset.description;
  if (description.is_object() && !folder.building &&
      description.value("samples", std::size_t{0}) != stored) {
    items.push_back(fmt::format("dataset.json counts {} samples, the shards hold {}",
                                description.value("samples", std::size_t{0}), stored));
  }
  if (folder.building) {
    return {
        "counts", Verdict::fail,
        fmt::format("a build is going on: {} of {} samples so far", stored, plan.samples.size()),
        "wait for it, then check again", std::move(items)};
  }
  Finding finding =
      judged("counts", std::move(items),
             fmt::format("{} samples of {} shapes, as planned", stored, plan.shapes.size()),
             fmt::format("{} of {} planned samples", stored, plan.samples.size()),
             "run the build again into this folder: what is missing is made");
  if (finding.verdict == Verdict::pass && failed > 0) {
    finding.verdict = Verdict::note;
    finding.text = fmt::format("{} of {} planned samples; failures.json explains the other {}",
                               stored, plan.samples.size(), failed);
  }
  return finding;
}

Finding check_failures(const DatasetFolder& folder) {
  const json& failures = folder.failures;
  if (failures.is_null() && folder.building) {
    return {"failures", Verdict::pass, "not written yet", "", {}};
  }
  std::vector<std::string> items;
  if (!failures.is_array()) {
    items.push_back("failures.json is not there, or is no JSON list");
  } else {
    std::set<std::string> planned, listed;
    for (const plan::BuildTask& task : folder.dataset.build.plan.tasks) planned.insert(task.key);
    for (const run::ListedFile& file : folder.listed) listed.insert(file.path);
    for (const json& failure : failures) {
      if (!failure.is_object() || !failure.value("task", json()).is_string() ||
          !failure.value("message", json()).is_string()) {
        items.push_back("an entry has no task or no message: " + failure.dump());
      }
    }
    if (items.empty()) {
      for (const std::string& task : explained(failures)) {
        if (!planned.contains(task)) items.push_back(task + " is no task of this build");
        if (listed.contains(task + ".h5")) {
          items.push_back(task + " is said to have failed, and its file is listed");
        }
      }
    }
  }
  const std::size_t count = failures.is_array() ? failures.size() : 0;
  Finding finding = judged("failures", std::move(items),
                           count == 0 ? "no task failed" : fmt::format("{} tasks failed", count),
                           "failures.json does not fit the dataset",
                           "run the build again into this folder: it writes the file anew");
  if (finding.verdict == Verdict::pass && count > 0) {
    finding.verdict = Verdict::note;
    for (const json& failure : failures) {
      finding.items.push_back(failure.at("task").get<std::string>() + ": " +
                              failure.at("message").get<std::string>());
    }
  }
  return finding;
}

Finding check_warnings(const DatasetFolder& folder) {
  const json warnings = read_list(folder.dataset.folder / "warnings.json");
  Finding finding{"warnings", Verdict::pass, "none", "", {}};
  if (!warnings.is_array() || warnings.empty()) return finding;
  finding.verdict = Verdict::note;
  finding.text = fmt::format("{} warnings about bodies", warnings.size());
  for (const json& warning : warnings) {
    if (!warning.is_object()) continue;
    finding.items.push_back(warning.value("task", "") + ": " + warning.value("message", ""));
  }
  return finding;
}

Finding check_pitches(const DatasetFolder& folder) {
  const samples::BuildFolders folders{folder.dataset.folder, {}};
  struct Object {
    const std::string* id;
    double worst, median;
  };
  std::vector<Object> objects;
  for (const plan::Shape& shape : folder.dataset.build.plan.shapes) {
    const fs::path path = folders.modes_file(shape);
    if (!fs::is_regular_file(path)) continue;
    std::vector<double> errors;
    try {
      errors = samples::read_pitch_errors(core::Hdf5Group::open_file(path));
    } catch (const core::FileError&) {
      // A damaged file is the business of its checksum.
    }
    if (errors.empty()) continue;
    objects.push_back(
        {&shape.id, *std::max_element(errors.begin(), errors.end()), core::median(errors)});
  }
  Finding finding{"pitches", Verdict::note, "no mode is there yet", "", {}};
  if (objects.empty()) return finding;
  std::stable_sort(objects.begin(), objects.end(),
                   [](const Object& a, const Object& b) { return a.worst > b.worst; });
  finding.text = fmt::format("estimated to be within {:.3g} cents", objects.front().worst);
  for (const Object& object : objects)
    finding.items.push_back(fmt::format("{}: worst {:.3g} cents, median {:.3g}", *object.id,
                                        object.worst, object.median));
  return finding;
}

Finding check_foreign_files(const DatasetFolder& folder) {
  const fs::path& root = folder.dataset.folder;
  std::set<std::string> known = {"index.h5",           "dataset.json",   "failures.json",
                                 "warnings.json",      "croissant.json", "trace.json",
                                 "journal.jsonl",      "status.json",    ".lock",
                                 "configuration.yaml", "README.md",      "LICENSE"};
  for (const run::ListedFile& file : folder.listed) known.insert(file.path);
  for (const configuration::InputFile& input :
       configuration::input_files(folder.dataset.build.config)) {
    known.insert("inputs/" + input.key);
  }
  std::vector<std::string> items;
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    if (entry.is_directory()) continue;
    const std::string name = entry.path().lexically_relative(root).generic_string();
    // Ranks of a build that runs or was killed; the next one removes it.
    if (name.starts_with("running/")) continue;
    // What was found in the sounds: `carillon evaluate`.
    if (name.starts_with("evaluation/")) continue;
    if (!known.contains(name)) items.push_back(name);
  }
  std::sort(items.begin(), items.end());
  const std::size_t count = items.size();
  Finding finding =
      judged("files", std::move(items), "nothing that does not belong",
             fmt::format("{} files are no part of the dataset", count), "move them elsewhere");
  if (folder.building && finding.verdict == Verdict::fail) finding.verdict = Verdict::note;
  return finding;
}

}  // namespace carillon::dataset::check
