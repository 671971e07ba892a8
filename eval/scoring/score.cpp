#include "eval/scoring/score.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/json.hpp"
#include "core/temporary_folder.hpp"
#include "core/text.hpp"
#include "eval/learning/read_task.hpp"
#include "eval/scoring/class_board.hpp"
#include "eval/scoring/object_entry.hpp"
#include "eval/scripts/run_script.hpp"

namespace carillon::eval::scoring {

namespace {

namespace fs = std::filesystem;

/// A longer one is no name.
constexpr std::size_t longest_name = 100;

core::CsvTable read_answers_table(const fs::path& path) {
  if (!fs::is_regular_file(path)) {
    throw core::FileError(fmt::format("{}: no such file", path.string()));
  }
  const std::string ending = path.extension().string();
  if (ending != ".npz" && ending != ".npy" && ending != ".parquet") {
    return core::read_csv(path, 0);
  }
  const core::TemporaryFolder folder;
  const fs::path table = folder.path() / (path.stem().string() + ".csv");
  const std::string module = ending == ".parquet" ? "pyarrow" : "numpy";
  const std::string reason =
      scripts::run_script("answers_to_csv", {path.string(), table.string()}, module);
  if (!reason.empty()) {
    throw core::InputError(fmt::format("{} cannot be read: {}", path.string(), reason),
                           "CSV is always read");
  }
  core::CsvTable read = core::read_csv(table, 0);
  // Rows are told by the file that was handed in.
  const auto tell = [&](core::CsvRow& row) {
    row.place.replace(0, table.string().size(), path.string());
  };
  tell(read.head);
  for (core::CsvRow& row : read.rows) tell(row);
  return read;
}

std::string entry_name(const AnswersFile& file) {
  std::string name = file.name.empty() ? file.path.stem().string() : file.name;
  if (name.size() > longest_name || name.find_first_of("\r\n\t|") != std::string::npos) {
    throw core::InputError(
        fmt::format("\"{}\" is no name of an entry", name.substr(0, longest_name)),
        "up to 100 characters, none of them | or a line break; --name gives one");
  }
  return name;
}

/// Tables by the names of their entries.
std::map<std::string, core::CsvTable> read_tables(const std::vector<AnswersFile>& files) {
  std::map<std::string, core::CsvTable> tables;
  for (const AnswersFile& file : files) {
    const std::string name = entry_name(file);
    if (!tables.emplace(name, read_answers_table(file.path)).second) {
      throw core::InputError(fmt::format("two files of answers are called {}", name),
                             "rename one, or hand them in one after the other with --name");
    }
  }
  return tables;
}

learning::TaskSpec task_of_configuration(const std::string& path, const std::string& name) {
  core::ConfigNode root = core::ConfigNode::parse(core::read_text_file(path), path);
  if (!root.has("train")) root.fail("train", "is missing, and its tasks were asked for");
  core::ConfigNode tasks = root.child("train").child("tasks");
  if (!tasks.has(name)) {
    tasks.fail("", fmt::format("has no task {}", name),
               fmt::format("--task names one of {}", fmt::join(tasks.keys(), ", ")));
  }
  core::ConfigNode node = tasks.child(name);
  const learning::TaskSpec task = learning::read_task(node, name);
  node.finish();
  return task;
}

/// What earlier entries answered by that name, as a configuration said then; else the column.
learning::TaskSpec task_known_as(const fs::path& evaluation, const std::string& name) {
  for (const fs::path& place : kept_entries(evaluation, name)) {
    const nlohmann::json about = core::read_json(place / "entry.json");
    if (about.is_object() && about.contains("task")) return learning::task_from(about.at("task"));
  }
  return task_of_column(name);
}

fs::path place_of(const fs::path& evaluation, const std::string& task, const std::string& name) {
  return entries_folder(evaluation, task) / core::file_safe(name);
}

std::string object_text(const ObjectEntry& entry) {
  std::string text = fmt::format("{}: {} objects\n", entry.name, entry.objects.size());
  const ObjectMeasure& first = entry.measures.front();
  std::vector<std::pair<double, std::string>> worst;
  for (std::size_t o = 0; o < entry.objects.size(); ++o) {
    worst.emplace_back(first.values[o], entry.objects[o]);
  }
  std::sort(worst.rbegin(), worst.rend());
  const double scale = first.unit == "%" ? 100 : 1;
  text += fmt::format("worst by {}:\n", first.name);
  for (std::size_t o = 0; o < std::min<std::size_t>(5, worst.size()); ++o) {
    text += fmt::format("  {:10.4g} {}  {}\n", scale * worst[o].first, first.unit, worst[o].second);
  }
  return text;
}

}  // namespace

Scored score(const ScoreRequest& request) {
  const fs::path dataset = core::tidy_path(request.dataset);
  Scored scored;
  scored.folder = (request.output.empty() ? dataset : request.output) / "evaluation";
  const auto seal = request.seal.empty()
                        ? std::nullopt
                        : std::optional(dataset::exporters::read_seal(request.seal));
  const std::map<std::string, core::CsvTable> tables = read_tables(request.answers);
  for (const ObjectTask task : {ObjectTask::damping, ObjectTask::modes}) {
    if (request.task != name_of(task) || !request.tasks.empty()) continue;
    const TrueObjects truth = open_true_objects(dataset, seal);
    std::vector<ObjectEntry> entries;
    for (const auto& [name, table] : tables) {
      entries.push_back(score_objects(table, name, task, truth));
    }
    for (const ObjectEntry& entry : entries) {
      const fs::path place = place_of(scored.folder, request.task, entry.name);
      keep_entry(entry, place);
      scored.entries.push_back(core::read_ordered_json(place / "entry.json"));
      scored.texts.push_back(object_text(entry));
    }
    scored.board = object_board(scored.folder, task, truth);
    write_board(scored.board, scored.folder);
    return scored;
  }
  const learning::TaskSpec task = request.tasks.empty()
                                      ? task_known_as(scored.folder, request.task)
                                      : task_of_configuration(request.tasks, request.task);
  const TestSet set = open_test_set(dataset, task, seal, request.cache);
  std::vector<ClassEntry> entries;
  for (const auto& [name, table] : tables) {
    entries.push_back(read_class_entry(table, name, set));
  }
  for (const ClassEntry& entry : entries) {
    const fs::path place = place_of(scored.folder, task.name, entry.name);
    keep_entry(entry, set, place);
    scored.entries.push_back(entry_json(entry, set));
    core::write_text_durably(place / "score.json", scored.entries.back().dump(1) + "\n");
    scored.texts.push_back(entry_text(entry, set));
  }
  scored.board = class_board(scored.folder, dataset / "evaluation" / "models", set);
  write_board(scored.board, scored.folder);
  return scored;
}

}  // namespace carillon::eval::scoring
