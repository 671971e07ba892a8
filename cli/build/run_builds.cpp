#include "cli/build/run_builds.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <set>
#include <unordered_map>

#include "cli/build/attempts.hpp"
#include "cli/build/check_files.hpp"
#include "cli/build/claim_folder.hpp"
#include "cli/build/costs.hpp"
#include "cli/build/index_keeper.hpp"
#include "cli/build/inputs.hpp"
#include "cli/build/last_words.hpp"
#include "cli/build/limits.hpp"
#include "cli/build/samples_task.hpp"
#include "cli/build/task_inputs.hpp"
#include "cli/build/task_times.hpp"
#include "cli/build/trace_json.hpp"
#include "core/files.hpp"
#include "core/progress.hpp"
#include "core/storage_error.hpp"
#include "mpi/comm.hpp"
#include "mpi/failure.hpp"
#include "mpi/interrupt.hpp"
#include "mpi/journal.hpp"
#include "mpi/witness.hpp"

namespace carillon::cli {

using nlohmann::json;

namespace {

std::filesystem::path journal_file(const BuildRun& run) {
  return run.folders.output / "journal.jsonl";
}

/// As CommonTasks::first.
std::vector<std::size_t> first_tasks(const std::vector<BuildRun>& builds) {
  std::vector<std::size_t> first = {0};
  for (const BuildRun& run : builds) first.push_back(first.back() + run.build.plan.tasks.size());
  return first;
}

/// What earlier runs left in a folder that is this build's now, without their leftovers.
Standing take_over(const BuildRun& run, const std::vector<json>& journal) {
  const auto& [build, folders, name] = run;
  core::remove_leftovers(folders.output, true);
  std::map<std::string, json> entries = finished_tasks(journal);
  keep_inputs(build.config, folders.output);
  drop_damaged(entries, folders.output);
  return sort_entries(build.config, build.plan, entries);
}

/// Warnings of all builds, each once.
void tell_warnings(const std::vector<BuildRun>& builds) {
  std::set<std::string> told;
  for (const BuildRun& run : builds) {
    for (const std::string& warning : run.build.config.warnings) {
      if (told.insert(warning).second) spdlog::warn("{}", warning);
    }
  }
}

/// The journals of builds; of more than a process may hold open, those at hand are.
class Journals {
 public:
  explicit Journals(const std::vector<BuildRun>& builds) : builds_(builds) {}

  mpi::Journal& of(std::size_t build) {
    constexpr std::size_t most_open = 200;
    if (!open_.contains(build) && open_.size() >= most_open) close();
    auto& journal = open_[build];
    if (!journal) journal = std::make_unique<mpi::Journal>(journal_file(builds_[build]));
    return *journal;
  }

  void close() { open_.clear(); }

 private:
  const std::vector<BuildRun>& builds_;
  std::map<std::size_t, std::unique_ptr<mpi::Journal>> open_;
};

/// All builds of a run while it goes on.
class Runner {
 public:
  Runner(const RunRequest& request, const Context& context);

  int run(const std::function<int(RunOutcome&)>& finish);

 private:
  struct Place {
    std::size_t build;
    const BuildTask& task;
  };
  void claim_folders();
  Place place_of(std::int64_t number) const;
  std::string inputs_of(std::size_t build, const std::string& task) const;

  void settle_earlier_attempts();
  mpi::TaskBoard make_board();
  bool is_settled(std::size_t build, const std::string& task, bool ok) const;
  void mark_settled(mpi::TaskBoard& board, std::size_t build) const;
  void give_up_alike(mpi::TaskBoard& board);
  void mark_given_up(mpi::TaskBoard& board) const;
  std::vector<std::int64_t> lost_with(std::int64_t number) const;
  void share_kept_samples();
  void write_results();

  std::string run_task(std::int64_t number, MPI_Comm group, mpi::Witness& witness) const;
  void record(std::int64_t number, json entry);
  mpi::ServiceHooks hooks(LastWords& last_words, core::Progress& progress, double expected);

  const RunRequest& request_;
  const Context& context_;
  const std::vector<BuildRun>& builds_;
  const std::vector<std::size_t> first_;
  std::vector<TaskInputs> inputs_;  ///< by build
  /// Place in a build's plan, by a task's key.
  std::vector<std::unordered_map<std::string, std::size_t>> places_;
  /// Of tasks that continue a shard, by build and key: samples that are there.
  std::vector<std::map<std::string, std::size_t>> kept_samples_;

  // The host's.
  std::unordered_map<std::string, std::int64_t> numbers_;  ///< on the board, by key there
  SameWork same_work_;
  std::vector<std::vector<std::string>> given_up_;  ///< just now, by build
  std::vector<Standing> standings_;
  Journals journals_;
  std::unique_ptr<IndexKeeper> index_;
  RunOutcome outcome_;
};

Runner::Runner(const RunRequest& request, const Context& context)
    : request_(request),
      context_(context),
      builds_(request.builds),
      first_(first_tasks(builds_)),
      places_(builds_.size()),
      kept_samples_(builds_.size()),
      standings_(builds_.size()),
      journals_(builds_) {
  inputs_.reserve(builds_.size());
  for (std::size_t b = 0; b < builds_.size(); ++b) {
    const LoadedBuild& build = builds_[b].build;
    inputs_.emplace_back(build.config, build.plan);
    for (std::size_t t = 0; t < build.plan.tasks.size(); ++t) {
      places_[b].emplace(build.plan.tasks[t].key, t);
    }
  }
  outcome_.builds.resize(builds_.size());
}

Runner::Place Runner::place_of(std::int64_t number) const {
  const auto task = static_cast<std::size_t>(number);
  const auto after = std::upper_bound(first_.begin(), first_.end(), task);
  const auto build = static_cast<std::size_t>(after - first_.begin() - 1);
  return {build, builds_[build].build.plan.tasks[task - first_[build]]};
}

std::string Runner::inputs_of(std::size_t build, const std::string& task) const {
  const auto found = places_[build].find(task);
  return found == places_[build].end()
             ? ""
             : inputs_[build].of(builds_[build].build.plan.tasks[found->second]);
}

/// A folder of another configuration is refused before anything is written into any.
void Runner::claim_folders() {
  mpi::agreed(context_.world, [&] {
    if (!context_.speaks()) return;
    for (std::size_t b = 0; b < builds_.size(); ++b) {
      claim_folder(builds_[b].build, builds_[b].folders.output,
                   finished_tasks(journals_.of(b).entries()));
    }
    journals_.close();  // others write into them next
  });
}

void Runner::settle_earlier_attempts() {
  std::vector<AttemptedBuild> attempted;
  for (std::size_t b = 0; b < builds_.size(); ++b) {
    attempted.push_back({builds_[b].name, journal_file(builds_[b]),
                         [this, b](const std::string& task) { return inputs_of(b, task); }});
  }
  given_up_ = settle_attempts(request_.output, attempted, context_.world);
}

/// What is left to do of all builds, one after the other on one board.
mpi::TaskBoard Runner::make_board() {
  std::set<std::filesystem::path> caches;
  for (const BuildRun& run : builds_) caches.insert(run.folders.cache);
  for (const std::filesystem::path& cache : caches) {
    if (!cache.empty()) core::remove_leftovers(cache, false);
  }
  CommonTasks common = common_tasks(builds_);
  for (std::size_t b = 0; b < builds_.size(); ++b) {
    const std::vector<json> journal = journals_.of(b).entries();
    standings_[b] = take_over(builds_[b], journal);
    outcome_.run = std::max(outcome_.run, next_run(journal));
    for (std::size_t t = first_[b]; t < first_[b + 1]; ++t) {
      const auto number = static_cast<std::int64_t>(t);
      numbers_.emplace(common.tasks[t].key, number);
      common.done[t] = is_settled(b, place_of(number).task.key, true);
    }
  }
  if (request_.order) same_work_ = request_.order(common);
  mpi::TaskBoard board(std::move(common.tasks));
  for (std::size_t b = 0; b < builds_.size(); ++b) mark_settled(board, b);
  mark_given_up(board);
  give_up_alike(board);
  return board;
}

/// An earlier run did a task, or gave it up.
bool Runner::is_settled(std::size_t build, const std::string& task, bool ok) const {
  const auto& finished = standings_[build].finished;
  const auto found = finished.find(task);
  return found != finished.end() && found->second.at("ok").get<bool>() == ok;
}

/// What ended the run before this one too often is not tried by this one, even to retry what
/// failed: a command that is repeated after each crash would never end.
void Runner::mark_given_up(mpi::TaskBoard& board) const {
  for (std::size_t b = 0; b < given_up_.size(); ++b) {
    for (const std::string& task : given_up_[b]) {
      const auto number = numbers_.find(builds_[b].name + task);
      if (number == numbers_.end()) continue;
      if (board.state(number->second) == mpi::TaskState::waiting) board.mark_failed(number->second);
    }
  }
}

/// Marks what an earlier run settled.
void Runner::mark_settled(mpi::TaskBoard& board, std::size_t build) const {
  const auto& tasks = builds_[build].build.plan.tasks;
  // What is done comes first: it stays done whatever became of what it needed.
  for (std::size_t t = 0; t < tasks.size(); ++t) {
    if (is_settled(build, tasks[t].key, true))
      board.mark_done(static_cast<std::int64_t>(first_[build] + t));
  }
  for (std::size_t t = 0; t < tasks.size() && !request_.retry_failed; ++t) {
    if (!is_settled(build, tasks[t].key, false)) continue;
    board.mark_failed(static_cast<std::int64_t>(first_[build] + t));
  }
}

/// What does the same as a task that an earlier run gave up is given up too.
void Runner::give_up_alike(mpi::TaskBoard& board) {
  for (const auto& [work, others] : same_work_) {
    const std::int64_t leader = work.first;
    if (board.state(leader) != mpi::TaskState::failed) continue;
    const auto [build, task] = place_of(leader);
    for (const std::int64_t number : lost_with(leader)) {
      if (board.state(number) != mpi::TaskState::waiting) continue;
      json entry = standings_[build].finished.at(task.key);
      entry.erase("times");
      board.mark_failed(number);
      record(number, std::move(entry));
    }
  }
}

/// Tasks that a failure concerns beside the one that met it.
std::vector<std::int64_t> Runner::lost_with(std::int64_t number) const {
  const auto [build, task] = place_of(number);
  const std::string stage = standings_[build].finished.at(task.key).value("stage", "");
  const auto found = same_work_.find({number, stage});
  return found == same_work_.end() ? std::vector<std::int64_t>{} : found->second;
}

void Runner::share_kept_samples() {
  for (std::size_t b = 0; b < builds_.size(); ++b) {
    for (const auto& [task, entry] : standings_[b].grown) {
      kept_samples_[b][task] = entry.at("samples");
    }
  }
  kept_samples_ = json::parse(mpi::broadcast(json(kept_samples_).dump(), 0, context_.world))
                      .get<std::vector<std::map<std::string, std::size_t>>>();
}

/// One task on the ranks of a group; returns its journal record.
std::string Runner::run_task(std::int64_t number, MPI_Comm group, mpi::Witness& witness) const {
  const auto [b, task] = place_of(number);
  const auto& [build, folders, name] = builds_[b];
  const double start = core::monotonic_seconds();
  ModesTaskResult result;
  core::Trace own;
  watch_task(witness, build.config.limits, name + task.key, own, group, [&] {
    if (task.kind == TaskKind::modes) {
      result = run_modes_task(build.config, build.plan.shapes[task.shape], folders, group, own);
    } else {
      const auto kept = kept_samples_[b].find(task.key);
      result.written = run_samples_task(build.config, build.plan, task, folders, own,
                                        kept == kept_samples_[b].end() ? 0 : kept->second);
    }
  });
  json times = json::array();
  for (const std::string& file : result.written)
    times.push_back(modified_ns(folders.output / file));
  json record = {{"inputs", inputs_[b].of(task)},
                 {"samples", task.count},
                 {"files", describe_files(result.written, folders.output)},
                 {"modified_ns", times},
                 {"seconds", core::monotonic_seconds() - start},
                 {"trace", to_json(own)}};
  if (!result.pitch_target.is_null()) record["pitch_target"] = result.pitch_target;
  return record.dump();
}

/// A task has ended: into its build's journal, index and what is known of it.
/// @param entry  as a journal has it, but for what is this task's alone
void Runner::record(std::int64_t number, json entry) {
  const auto [b, task] = place_of(number);
  entry["task"] = task.key;
  if (!entry.at("ok").get<bool>()) {
    entry["inputs"] = inputs_[b].of(task);
  } else if (const auto old = standings_[b].grown.find(task.key);
             old != standings_[b].grown.end()) {
    entry["kept"] = to_json(trace_of(old->second));
  }
  journals_.of(b).append(entry);
  if (index_) index_->add(b, entry);
  standings_[b].finished[task.key] = std::move(entry);
}

mpi::ServiceHooks Runner::hooks(LastWords& last_words, core::Progress& progress, double expected) {
  mpi::ServiceHooks hooks;
  hooks.completed = [this, &last_words](const mpi::Task& task, const mpi::Outcome& ended) {
    json entry = json::parse(ended.record);
    // A full disk is nobody's failure: nothing is recorded, and the run ends.
    if (entry.value("kind", "") == "StorageError") {
      throw core::StorageError(entry.at("message"), entry.value("hint", ""));
    }
    entry["ok"] = ended.ok;
    entry["times"] = describe_times(task, ended.times, outcome_.run);
    const std::int64_t number = numbers_.at(task.key);
    last_words.count([&] { record(number, std::move(entry)); });
    ++outcome_.builds[place_of(number).build].tasks_run;
  };
  hooks.lost_with = [this](const mpi::Task& task) { return lost_with(numbers_.at(task.key)); };
  hooks.progress = [&progress, expected](const mpi::TaskBoard& now) {
    // Costs grow and shrink as tasks tell how long they take.
    progress.update(
        expected * now.settled_cost() / std::max(now.total_cost(), 1e-300),
        fmt::format("{} of {} tasks", now.count(mpi::TaskState::done), now.tasks().size()));
  };
  return hooks;
}

/// What the folders hold now, on the host.
void Runner::write_results() {
  mpi::agreed(context_.world, [&] {
    if (!context_.speaks()) return;
    std::vector<Results> results;
    if (index_) results = index_->finish();
    for (std::size_t b = 0; b < builds_.size(); ++b) {
      EndedBuild& ended = outcome_.builds[b];
      ended.finished = std::move(standings_[b].finished);
      ended.results =
          index_ ? std::move(results[b])
                 : cli::write_results(builds_[b].build, builds_[b].folders, ended.finished);
    }
    if (index_) outcome_.index = index_->cost();
  });
}

int Runner::run(const std::function<int(RunOutcome&)>& finish) {
  const bool host = context_.speaks();
  claim_folders();
  settle_earlier_attempts();
  mpi::TaskBoard board;
  mpi::agreed(context_.world, [&] {
    if (host) board = make_board();
  });
  share_kept_samples();
  const bool idle = board.count(mpi::TaskState::waiting) == 0;
  if (host && !idle) {
    tell_warnings(builds_);
    std::vector<KeptIndex> kept;
    for (std::size_t b = 0; b < builds_.size(); ++b) {
      kept.push_back({&builds_[b].build, &builds_[b].folders, standings_[b].finished});
    }
    index_ = std::make_unique<IndexKeeper>(std::move(kept));
  }
  const double expected = board.total_cost();
  core::Progress progress("build", expected, context_.quiet || context_.json || !host || idle);
  LastWords last_words(index_.get(), request_.tell_interrupted);
  const mpi::InterruptGuard guard(last_words.leaving());
  std::optional<mpi::Witness> witness;
  mpi::agreed(context_.world, [&] {
    witness.emplace(witness_file(request_.output, mpi::rank(context_.world)),
                    mpi::size(context_.world), exit_overdue);
  });
  mpi::RunReport report = mpi::run_tasks(
      context_.world, std::move(board), hooks(last_words, progress, expected),
      [&](std::int64_t number, MPI_Comm group) { return run_task(number, group, *witness); },
      mpi::describe_machine(context_.world, builds_.front().build.config.ranks.memory_per_node));
  witness.reset();
  last_words.keep();
  progress.finish("");

  outcome_.interrupted = report.interrupted;
  outcome_.ranks = gather_times(report.times, context_.world);
  outcome_.calibration = std::move(report.calibration);
  write_results();
  const int code = finish(outcome_);
  return std::stoi(mpi::broadcast(std::to_string(code), 0, context_.world));
}

}  // namespace

CommonTasks common_tasks(const std::vector<BuildRun>& builds) {
  CommonTasks common{{}, first_tasks(builds), {}};
  for (std::size_t b = 0; b < builds.size(); ++b) {
    for (mpi::Task& task : board_tasks(builds[b].build.plan, builds[b].build.config)) {
      task.key = builds[b].name + task.key;
      for (std::int64_t& earlier : task.after) {
        earlier += static_cast<std::int64_t>(common.first[b]);
      }
      common.tasks.push_back(std::move(task));
    }
  }
  common.done.assign(common.tasks.size(), false);
  return common;
}

std::int64_t RunOutcome::tasks_run() const {
  std::int64_t sum = 0;
  for (const EndedBuild& build : builds) sum += build.tasks_run;
  return sum;
}

int run_builds(const RunRequest& request, const Context& context,
               const std::function<int(RunOutcome&)>& finish) {
  return Runner(request, context).run(finish);
}

json describe_trace(const LoadedBuild& build, const std::map<std::string, json>& finished,
                    const Results& results) {
  json document = to_json(total_trace(finished));
  document["configuration_folder"] = configuration_folder(build.path);
  document["missed_pitch_targets"] = results.missed.size();
  document["tasks"] = task_rows(finished);
  return document;
}

void keep_trace(const std::filesystem::path& folder, json& document, const RunOutcome* outcome) {
  const std::filesystem::path path = folder / "trace.json";
  json old = json::object();
  try {
    if (std::filesystem::exists(path)) old = json::parse(core::read_file(path));
  } catch (const std::exception&) {
    // Only times are lost.
  }
  const bool ran = outcome != nullptr && outcome->tasks_run() > 0;
  if (!ran && old.value("tasks", json()) == document.at("tasks")) return;
  for (const char* key : {"runs", "ranks", "index"}) {
    if (old.contains(key)) document[key] = old.at(key);
  }
  if (ran) {
    document["index"] = {{"calls", outcome->index.calls}, {"seconds", outcome->index.seconds}};
    document["runs"].push_back(
        describe_run(outcome->run, outcome->ranks, outcome->calibration, document.at("tasks")));
    document["ranks"] = document["runs"].back().at("ranks");
  }
  core::write_text_durably(path, document.dump(2) + "\n");
}

}  // namespace carillon::cli
