#include "dataset/run/detail/run_state.hpp"

#include <algorithm>
#include <set>

#include "core/files.hpp"
#include "dataset/configuration/inputs.hpp"
#include "dataset/plan/task_times.hpp"
#include "dataset/run/check_files.hpp"
#include "dataset/run/detail/claim_folder.hpp"
#include "dataset/run/progress_so_far.hpp"
#include "dataset/run/trace_json.hpp"
#include "mpi/comm.hpp"

namespace carillon::dataset::run {

using nlohmann::json;

namespace {

std::filesystem::path journal_file(const BuildRun& run) {
  return run.folders.output / "journal.jsonl";
}

/// What earlier runs left in a folder that is this build's now, without their leftovers.
Standing standing_of(const BuildRun& run, const std::vector<json>& journal) {
  const auto& [build, folders, name] = run;
  core::remove_leftovers(folders.output, true);
  std::map<std::string, json> entries = finished_tasks(journal);
  configuration::keep_inputs(build.config, folders.output);
  drop_damaged(entries, folders.output);
  return sort_entries(build.config, build.plan, entries);
}

}  // namespace

mpi::Journal& Journals::of(std::size_t build) {
  constexpr std::size_t max_open = 200;
  if (!open_.contains(build) && open_.size() >= max_open) close();
  auto& journal = open_[build];
  if (!journal) journal = std::make_unique<mpi::Journal>(journal_file(builds_[build]));
  return *journal;
}

RunState::RunState(const std::vector<BuildRun>& builds)
    : builds_(builds), kept_samples_(builds.size()), standings_(builds.size()), journals_(builds) {
  first_.push_back(0);
  inputs_.reserve(builds_.size());
  for (const BuildRun& run : builds_) {
    first_.push_back(first_.back() + run.build.plan.tasks.size());
    inputs_.emplace_back(run.build.config, run.build.plan);
  }
}

mpi::TaskBoard RunState::take_over(const std::filesystem::path& output, const OrderTasks& order,
                                   bool retry_failed, MPI_Comm world) {
  const bool host = mpi::rank(world) == 0;
  mpi::agreed(world, [&] {
    if (host) claim_folders();
  });
  settle_earlier_attempts(output, world);
  mpi::TaskBoard board;
  mpi::agreed(world, [&] {
    if (host) board = make_board(order, retry_failed);
  });
  share_kept_samples(world);
  return board;
}

RunState::Place RunState::place_of(std::int64_t number) const {
  const auto task = static_cast<std::size_t>(number);
  const auto after = std::upper_bound(first_.begin(), first_.end(), task);
  const auto build = static_cast<std::size_t>(after - first_.begin() - 1);
  return {build, builds_[build].build.plan.tasks[task - first_[build]]};
}

std::string RunState::inputs_of(std::int64_t number) const {
  const auto [build, task] = place_of(number);
  return inputs_[build].of(task);
}

std::size_t RunState::kept_samples(std::int64_t number) const {
  const auto [build, task] = place_of(number);
  const auto found = kept_samples_[build].find(task.key);
  return found == kept_samples_[build].end() ? 0 : found->second;
}

/// A folder of another configuration is refused before anything is written into any.
void RunState::claim_folders() {
  for (std::size_t b = 0; b < builds_.size(); ++b) {
    claim_folder(builds_[b].build, builds_[b].folders.output,
                 finished_tasks(journals_.of(b).entries()));
  }
  journals_.close();  // others write into them next
}

void RunState::settle_earlier_attempts(const std::filesystem::path& output, MPI_Comm world) {
  std::vector<AttemptedBuild> attempted;
  for (std::size_t b = 0; b < builds_.size(); ++b) {
    std::map<std::string, const plan::BuildTask*> tasks;
    for (const plan::BuildTask& task : builds_[b].build.plan.tasks) tasks[task.key] = &task;
    attempted.push_back({builds_[b].name, journal_file(builds_[b]),
                         [this, b, tasks = std::move(tasks)](const std::string& key) {
                           const auto found = tasks.find(key);
                           return found == tasks.end() ? "" : inputs_[b].of(*found->second);
                         }});
  }
  attempts_ = settle_attempts(output, attempted, world);
}

mpi::TaskBoard RunState::make_board(const OrderTasks& order, bool retry_failed) {
  std::set<std::filesystem::path> caches;
  for (const BuildRun& run : builds_) caches.insert(run.folders.cache);
  for (const std::filesystem::path& cache : caches) {
    if (!cache.empty()) core::remove_leftovers(cache, false);
  }
  CommonTasks common = common_tasks(builds_);
  for (std::size_t b = 0; b < builds_.size(); ++b) {
    const std::vector<json> journal = journals_.of(b).entries();
    standings_[b] = standing_of(builds_[b], journal);
    run_ = std::max(run_, plan::next_run(journal));
    for (std::size_t t = first_[b]; t < first_[b + 1]; ++t) {
      const auto number = static_cast<std::int64_t>(t);
      numbers_.emplace(common.tasks[t].key, number);
      common.done[t] = is_settled(b, place_of(number).task.key, true);
    }
  }
  for (const std::int64_t number : numbers_of(&Attempts::open)) {
    common.tasks[static_cast<std::size_t>(number)].alone = true;
  }
  if (order) same_work_ = order(common);
  mpi::TaskBoard board(std::move(common.tasks));
  for (std::size_t b = 0; b < builds_.size(); ++b) mark_settled(board, b, retry_failed);
  mark_given_up(board);
  give_up_alike(board);
  return board;
}

/// An earlier run did a task, or gave it up.
bool RunState::is_settled(std::size_t build, const std::string& task, bool ok) const {
  const auto& finished = standings_[build].finished;
  const auto found = finished.find(task);
  return found != finished.end() && found->second.at("ok").get<bool>() == ok;
}

/// Of tasks that earlier runs tried, those of the plan.
std::vector<std::int64_t> RunState::numbers_of(std::vector<std::string> Attempts::*which) const {
  std::vector<std::int64_t> numbers;
  for (std::size_t b = 0; b < attempts_.size(); ++b) {
    for (const std::string& task : attempts_[b].*which) {
      const auto number = numbers_.find(builds_[b].name + task);
      if (number != numbers_.end()) numbers.push_back(number->second);
    }
  }
  return numbers;
}

/// What ended the run before this one too often is not tried by this one, even to retry what
/// failed: a command that is repeated after each crash would never end.
void RunState::mark_given_up(mpi::TaskBoard& board) const {
  for (const std::int64_t number : numbers_of(&Attempts::given_up)) {
    if (board.state(number) == mpi::TaskState::waiting) board.mark_failed(number);
  }
}

/// Marks what an earlier run settled.
void RunState::mark_settled(mpi::TaskBoard& board, std::size_t build, bool retry_failed) const {
  const auto& tasks = builds_[build].build.plan.tasks;
  // What is done comes first: it stays done whatever became of what it needed.
  for (std::size_t t = 0; t < tasks.size(); ++t) {
    if (is_settled(build, tasks[t].key, true))
      board.mark_done(static_cast<std::int64_t>(first_[build] + t));
  }
  for (std::size_t t = 0; t < tasks.size() && !retry_failed; ++t) {
    if (!is_settled(build, tasks[t].key, false)) continue;
    board.mark_failed(static_cast<std::int64_t>(first_[build] + t));
  }
}

/// What does the same as a task that an earlier run gave up is given up too.
void RunState::give_up_alike(mpi::TaskBoard& board) {
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
std::vector<std::int64_t> RunState::lost_with(std::int64_t number) const {
  const auto [build, task] = place_of(number);
  const std::string stage = standings_[build].finished.at(task.key).value("stage", "");
  const auto found = same_work_.find({number, stage});
  return found == same_work_.end() ? std::vector<std::int64_t>{} : found->second;
}

void RunState::share_kept_samples(MPI_Comm world) {
  for (std::size_t b = 0; b < builds_.size(); ++b) {
    for (const auto& [task, entry] : standings_[b].grown) {
      kept_samples_[b][task] = entry.at("samples");
    }
  }
  kept_samples_ = json::parse(mpi::broadcast(json(kept_samples_).dump(), 0, world))
                      .get<std::vector<std::map<std::string, std::size_t>>>();
}

const json& RunState::record(std::int64_t number, json entry) {
  const auto [b, task] = place_of(number);
  entry["task"] = task.key;
  if (!entry.at("ok").get<bool>()) {
    entry["inputs"] = inputs_[b].of(task);
  } else if (const auto old = standings_[b].grown.find(task.key);
             old != standings_[b].grown.end()) {
    entry["kept"] = to_json(trace_of(old->second));
  }
  journals_.of(b).append(entry);
  return standings_[b].finished[task.key] = std::move(entry);
}

}  // namespace carillon::dataset::run
