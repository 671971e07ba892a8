#include "dataset/run/detail/attempts.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <map>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>

#include "core/text.hpp"
#include "mpi/comm.hpp"
#include "mpi/journal.hpp"
#include "mpi/running_task.hpp"

namespace carillon::dataset::run {

using nlohmann::json;

namespace {

constexpr int max_attempts = 2;

std::filesystem::path running_folder(const std::filesystem::path& output) {
  return output / "running";
}

/// What ranks left behind, each task once.
std::map<std::string, mpi::BegunTask> take_begun_tasks(const std::filesystem::path& output) {
  std::map<std::string, mpi::BegunTask> tasks;
  for (mpi::BegunTask& begun : mpi::begun_tasks(running_folder(output))) {
    mpi::BegunTask& known = tasks[begun.task];
    if (known.overdue.empty()) known = std::move(begun);
  }
  // A run that is killed right here has not counted them: better than to count them twice.
  std::filesystem::remove_all(running_folder(output));
  return tasks;
}

/// A task's attempts since its last outcome.
struct Tried {
  int attempts = 0;
  json last{};
};

std::map<std::string, Tried> tried_tasks(const std::vector<json>& journal) {
  std::map<std::string, Tried> tried;
  for (const json& entry : journal) {
    if (entry.contains("task")) tried.erase(entry.at("task").get<std::string>());
    if (!entry.contains("attempt")) continue;
    Tried& one = tried[entry.at("attempt").get<std::string>()];
    ++one.attempts;
    one.last = entry;
  }
  return tried;
}

json to_entry(const std::string& task, const mpi::BegunTask& begun) {
  json entry = {{"attempt", task}};
  if (!begun.stage.empty()) entry["stage"] = begun.stage;
  if (!begun.item.empty()) entry["item"] = begun.item;
  if (!begun.overdue.empty()) entry["overdue"] = begun.overdue;
  return entry;
}

/// The outcome of a task that is given up; null while it may still be tried.
json verdict(const std::string& task, const Tried& tried) {
  json entry = {{"task", task}, {"ok", false}};
  for (const char* key : {"stage", "item"}) {
    if (tried.last.contains(key)) entry[key] = tried.last.at(key);
  }
  if (tried.last.contains("overdue")) {
    entry["kind"] = "TimeError";
    entry["message"] = tried.last.at("overdue");
    entry["hint"] =
        "it did not heed its limit, so that the run was ended; raise the limit, or "
        "look at it alone with the command in `reproduce`";
    return entry;
  }
  if (tried.attempts < max_attempts) return nullptr;
  entry["kind"] = "CrashError";
  entry["message"] = "the run ended while this task ran, twice";
  entry["hint"] =
      "the command in `reproduce` runs it alone; where memory ran out, fewer ranks on a machine, a "
      "lower solver.memory_limit or a coarser mesh need less; where somebody ended these runs, "
      "--retry-failed tries it again";
  return entry;
}

Attempts settle(const AttemptedBuild& build, const std::map<std::string, mpi::BegunTask>& begun) {
  mpi::Journal journal(build.journal);
  std::vector<json> entries = journal.entries();
  for (const auto& [name, one] : begun) {
    if (!name.starts_with(build.name)) continue;
    entries.push_back(to_entry(name.substr(build.name.size()), one));
    journal.append(entries.back());
    spdlog::warn("the last run ended while {} ran", name);
  }
  Attempts attempts;
  for (const auto& [task, tried] : tried_tasks(entries)) {
    json entry = verdict(task, tried);
    if (entry.is_null()) {
      attempts.open.push_back(task);
      continue;
    }
    entry["inputs"] = build.inputs_of(task);
    journal.append(entry);
    spdlog::warn("{}{} is given up: {}", build.name, task, entry.at("message").get<std::string>());
    attempts.given_up.push_back(task);
  }
  return attempts;
}

}  // namespace

std::filesystem::path running_file(const std::filesystem::path& output, int rank) {
  return running_folder(output) / fmt::format("rank-{:05}", rank);
}

int rank_of_running_file(const std::string& name) {
  constexpr std::string_view begin = "rank-";
  if (!name.starts_with(begin)) return -1;
  return static_cast<int>(core::number_in<std::int64_t>(name.substr(begin.size())).value_or(-1));
}

std::vector<Attempts> settle_attempts(const std::filesystem::path& output,
                                      const std::vector<AttemptedBuild>& builds, MPI_Comm world) {
  std::vector<Attempts> attempts(builds.size());
  mpi::agreed(world, [&] {
    if (mpi::rank(world) != 0) return;
    const auto begun = take_begun_tasks(output);
    for (std::size_t b = 0; b < builds.size(); ++b) attempts[b] = settle(builds[b], begun);
  });
  return attempts;
}

}  // namespace carillon::dataset::run
