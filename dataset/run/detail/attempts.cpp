#include "dataset/run/detail/attempts.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include "core/progress.hpp"
#include "mpi/blame.hpp"
#include "mpi/comm.hpp"
#include "mpi/journal.hpp"
#include "mpi/witness.hpp"

namespace carillon::dataset::run {

using nlohmann::json;

namespace {

constexpr int most_crashes = 2;
constexpr int most_silent_ends = 10;

std::filesystem::path witness_folder(const std::filesystem::path& output) {
  return output / "running";
}

/// Hosts of this run, to be asked about the one before.
std::vector<mpi::Host> gather_hosts(MPI_Comm world) {
  std::vector<mpi::Host> hosts;
  for (const std::string& text : mpi::all_gather(mpi::to_json(mpi::this_host()).dump(), world)) {
    hosts.push_back(mpi::host_from_json(json::parse(text)));
  }
  return hosts;
}

/// What the journal holds against a task since its last outcome.
struct Tally {
  int crashes = 0;  ///< and ends for lack of memory
  int silent = 0;
  bool overdue = false;
  json last;  ///< its last attempt
  std::vector<std::string> words;
};

struct Tallies {
  std::map<std::string, Tally> by_task;
  std::set<std::string> processes;  ///< whose end was counted
};

void count(const json& entry, Tallies& tallies) {
  if (entry.contains("task")) {
    tallies.by_task.erase(entry.at("task").get<std::string>());
    return;
  }
  if (!entry.contains("attempt")) return;
  Tally& tally = tallies.by_task[entry.at("attempt").get<std::string>()];
  const std::string evidence = entry.at("evidence");
  if (evidence == mpi::name_of(mpi::Blame::Evidence::overdue)) tally.overdue = true;
  if (evidence == mpi::name_of(mpi::Blame::Evidence::silence)) {
    ++tally.silent;
  } else {
    ++tally.crashes;
    tally.words.push_back(entry.at("words"));
  }
  tally.last = entry;
  tallies.processes.insert(entry.at("process").get<std::string>());
}

json to_entry(const mpi::Blame& blame, const std::string& task) {
  json entry = {{"attempt", task},
                {"evidence", mpi::name_of(blame.evidence)},
                {"words", blame.words},
                {"process", blame.process}};
  if (!blame.stage.empty()) entry["stage"] = blame.stage;
  if (!blame.item.empty()) entry["item"] = blame.item;
  return entry;
}

/// The outcome of a task that is given up; null while it may still be tried.
json verdict(const std::string& task, const Tally& tally) {
  json entry = {{"task", task}, {"ok", false}};
  for (const char* key : {"stage", "item"}) {
    if (tally.last.contains(key)) entry[key] = tally.last.at(key);
  }
  if (tally.overdue) {
    entry["kind"] = "TimeError";
    entry["message"] = tally.last.at("words");
    entry["hint"] =
        "it did not heed its limit, so that the run was ended; raise the limit, or "
        "look at it alone with the command in `reproduce`";
    return entry;
  }
  if (tally.crashes >= most_crashes) {
    const bool memory = tally.last.at("evidence") == mpi::name_of(mpi::Blame::Evidence::memory);
    entry["kind"] = memory ? "MemoryError" : "CrashError";
    entry["message"] =
        fmt::format("the run ended while this task ran, {}: {}",
                    tally.crashes == 2 ? "twice" : fmt::format("{} times", tally.crashes),
                    fmt::join(tally.words, ", then "));
    entry["hint"] = memory ? "fewer ranks on a machine, a lower solver.memory_limit or a coarser "
                             "mesh need less"
                           : "the command in `reproduce` runs it alone";
    return entry;
  }
  if (tally.silent >= most_silent_ends) {
    entry["kind"] = "CrashError";
    entry["message"] = fmt::format(
        "the run ended {} times while this task ran, each time without a sign why", tally.silent);
    entry["hint"] = "if somebody else ended these runs, --retry-failed tries it again";
    return entry;
  }
  return nullptr;
}

}  // namespace

std::filesystem::path witness_file(const std::filesystem::path& output, int rank) {
  return witness_folder(output) / fmt::format("rank-{:05}", rank);
}

namespace {

/// Adds what a run's witnesses say against a build's tasks to its journal.
/// @return tasks that are given up
std::vector<std::string> settle(const AttemptedBuild& build,
                                const std::vector<mpi::Blame>& blames) {
  mpi::Journal journal(build.journal);
  Tallies tallies;
  for (const json& entry : journal.entries()) count(entry, tallies);
  const std::set<std::string> counted = tallies.processes;
  for (const mpi::Blame& blame : blames) {
    // A run that was killed right here has counted it already.
    if (!blame.task.starts_with(build.name) || counted.contains(blame.process)) continue;
    const json entry = to_entry(blame, blame.task.substr(build.name.size()));
    journal.append(entry);
    count(entry, tallies);
    spdlog::warn("the last run ended while {} ran: {}", blame.task, blame.words);
  }
  std::vector<std::string> given_up;
  for (const auto& [task, tally] : tallies.by_task) {
    json entry = verdict(task, tally);
    if (entry.is_null()) continue;
    entry["inputs"] = build.inputs_of(task);
    journal.append(entry);
    spdlog::warn("{}{} is given up: {}", build.name, task, entry.at("message").get<std::string>());
    given_up.push_back(task);
  }
  return given_up;
}

}  // namespace

std::vector<std::vector<std::string>> settle_attempts(const std::filesystem::path& output,
                                                      const std::vector<AttemptedBuild>& builds,
                                                      MPI_Comm world) {
  const std::vector<mpi::Host> hosts = gather_hosts(world);
  std::vector<std::vector<std::string>> given_up(builds.size());
  mpi::agreed(world, [&] {
    if (mpi::rank(world) != 0) return;
    const std::vector<mpi::Blame> blames =
        mpi::blamed_tasks(mpi::read_testimonies(witness_folder(output)), hosts);
    for (std::size_t b = 0; b < builds.size(); ++b) given_up[b] = settle(builds[b], blames);
    std::error_code ignored;  // what is left behind is read again, and counted once
    std::filesystem::remove_all(witness_folder(output), ignored);
  });
  return given_up;
}

}  // namespace carillon::dataset::run
