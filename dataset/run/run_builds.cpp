#include "dataset/run/run_builds.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <set>

#include "core/host_name.hpp"
#include "core/json.hpp"
#include "core/progress.hpp"
#include "core/revision.hpp"
#include "core/storage_error.hpp"
#include "dataset/configuration/limits.hpp"
#include "dataset/plan/task_times.hpp"
#include "dataset/run/check_files.hpp"
#include "dataset/run/detail/attempts.hpp"
#include "dataset/run/detail/index_keeper.hpp"
#include "dataset/run/detail/last_words.hpp"
#include "dataset/run/detail/run_state.hpp"
#include "dataset/run/detail/status_file.hpp"
#include "dataset/run/detail/tally.hpp"
#include "dataset/run/status.hpp"
#include "dataset/run/trace_json.hpp"
#include "dataset/samples/samples_task.hpp"
#include "mpi/comm.hpp"
#include "mpi/exit_code.hpp"
#include "mpi/interrupt.hpp"
#include "mpi/running_task.hpp"

namespace carillon::dataset::run {

using nlohmann::json;
using nlohmann::ordered_json;

namespace {

/// Warnings of all builds, each once.
void tell_warnings(const std::vector<BuildRun>& builds) {
  std::set<std::string> told;
  for (const BuildRun& run : builds) {
    for (const std::string& warning : run.build.config.warnings) {
      if (told.insert(warning).second) spdlog::warn("{}", warning);
    }
  }
}

/// For those who ask for more than how far it is.
void tell_task(const mpi::Task& task, const mpi::Outcome& ended, const json& entry) {
  if (ended.ok) {
    spdlog::debug("{} in {} on rank{}", task.key, core::human_duration(ended.times.seconds),
                  ended.times.width == 1 ? fmt::format(" {}", ended.times.rank)
                                         : fmt::format("s {} to {}", ended.times.rank,
                                                       ended.times.rank + ended.times.width - 1));
  } else {
    spdlog::info("{} failed: {}", task.key, entry.value("message", ""));
  }
}

/// All builds of a run while it goes on.
class Runner {
 public:
  Runner(const RunRequest& request, MPI_Comm world)
      : request_(request),
        world_(world),
        host_(mpi::rank(world) == 0),
        builds_(request.builds),
        state_(request.builds),
        tally_(request.builds) {
    outcome_.builds.resize(builds_.size());
  }

  int run(const std::function<int(RunOutcome&)>& finish);

 private:
  std::string run_task(std::int64_t number, MPI_Comm group, mpi::RunningTask& running) const;
  mpi::ServiceHooks hooks(LastWords& last_words, core::Progress& progress, double expected,
                          StatusFile* status);
  std::unique_ptr<StatusFile> status_file(bool idle, const core::Progress& progress) const;
  ordered_json status(const core::Progress& progress) const;
  void keep_index();
  void write_results();
  int run_tasks(mpi::TaskBoard board, core::Progress& progress, StatusFile* status,
                const std::function<int(RunOutcome&)>& finish);

  const RunRequest& request_;
  const MPI_Comm world_;
  const bool host_;
  const std::vector<BuildRun>& builds_;
  RunState state_;
  Tally tally_;
  std::unique_ptr<IndexKeeper> index_;  ///< the host's, where something is left to do
  RunOutcome outcome_;
};

/// One task on the ranks of a group; returns its journal record.
std::string Runner::run_task(std::int64_t number, MPI_Comm group, mpi::RunningTask& running) const {
  const RunState::Place place = state_.place_of(number);
  const plan::BuildTask& task = place.task;
  const BuildRun& run = builds_[place.build];
  const LoadedBuild& build = run.build;
  const samples::BuildFolders& folders = run.folders;
  const double start = core::monotonic_seconds();
  samples::ModesTaskResult result;
  core::Trace own;
  configuration::watch_task(running, build.config.limits, run.name + task.key, own, group, [&] {
    if (task.kind == plan::TaskKind::modes) {
      result =
          samples::run_modes_task(build.config, build.plan.shapes[task.shape], folders, group, own);
    } else {
      result.written = samples::run_samples_task(build.config, build.plan, task, folders, own,
                                                 state_.kept_samples(number));
    }
  });
  json times = json::array();
  for (const std::string& file : result.written)
    times.push_back(modified_ns(folders.output / file));
  json record = {{"inputs", state_.inputs_of(number)},
                 {"samples", task.count},
                 {"files", describe_files(result.written, folders.output)},
                 {"modified_ns", times},
                 {"seconds", core::monotonic_seconds() - start},
                 {"trace", to_json(own)}};
  if (!result.warnings.empty()) record["warnings"] = result.warnings;
  if (!result.pitch_target.is_null()) record["pitch_target"] = result.pitch_target;
  return record.dump();
}

mpi::ServiceHooks Runner::hooks(LastWords& last_words, core::Progress& progress, double expected,
                                StatusFile* status) {
  mpi::ServiceHooks hooks;
  hooks.completed = [this, &last_words](const mpi::Task& task, const mpi::Outcome& ended) {
    json entry = json::parse(ended.record);
    // A full disk is nobody's failure: nothing is recorded, and the run ends.
    if (entry.value("kind", "") == "StorageError") {
      throw core::StorageError(entry.at("message"), entry.value("hint", ""));
    }
    entry["ok"] = ended.ok;
    entry["times"] = plan::to_json(
        plan::TaskRow{task.key, task.kind, state_.run(), task.cost / task.width, ended.times});
    const std::int64_t number = state_.number_of(task.key);
    const std::size_t build = state_.place_of(number).build;
    tell_task(task, ended, entry);
    last_words.count([&] {
      const json& recorded = state_.record(number, std::move(entry));
      tally_.count(build, state_.place_of(number).task, recorded);
      index_->add(build, recorded);
    });
    ++outcome_.builds[build].tasks_run;
  };
  hooks.lost_with = [this](const mpi::Task& task) {
    return state_.lost_with(state_.number_of(task.key));
  };
  hooks.progress = [this, &progress, status, expected](const mpi::TaskBoard& now) {
    // Costs grow and shrink as tasks tell how long they take.
    progress.update(expected * now.settled_cost() / std::max(now.total_cost(), 1e-300),
                    tally_.text(progress.elapsed_s()));
    if (status != nullptr) status->update(this->status(progress));
  };
  return hooks;
}

void Runner::keep_index() {
  std::vector<KeptIndex> kept;
  for (std::size_t b = 0; b < builds_.size(); ++b) {
    kept.push_back({&builds_[b].build, &builds_[b].folders, state_.finished(b)});
  }
  index_ = std::make_unique<IndexKeeper>(std::move(kept));
}

/// What the folders hold now, on the host.
void Runner::write_results() {
  mpi::agreed(world_, [&] {
    if (!host_) return;
    std::vector<Results> results;
    if (index_) results = index_->finish();
    for (std::size_t b = 0; b < builds_.size(); ++b) {
      EndedBuild& ended = outcome_.builds[b];
      ended.finished = std::move(state_.finished(b));
      ended.results =
          index_ ? std::move(results[b])
                 : run::write_results(builds_[b].build, builds_[b].folders, ended.finished);
    }
    if (index_) outcome_.index = index_->cost();
  });
}

/// status.json, on the host; none where nothing is left to do and that is known.
std::unique_ptr<StatusFile> Runner::status_file(bool idle, const core::Progress& progress) const {
  if (!host_) return nullptr;
  const json last = core::read_json(request_.output / status_name);
  if (idle && last.is_object() && last.value("state", "") == "done") return nullptr;
  return std::make_unique<StatusFile>(request_.output,
                                      ordered_json{{"name", request_.name},
                                                   {"carillon", core::revision()},
                                                   {"host", core::host_name()},
                                                   {"process", getpid()},
                                                   {"ranks", mpi::size(world_)},
                                                   {"run", state_.run()}},
                                      status(progress));
}

ordered_json Runner::status(const core::Progress& progress) const {
  const auto or_null = [](const std::optional<double>& value) {
    return value ? ordered_json(*value) : ordered_json(nullptr);
  };
  const double elapsed = progress.elapsed_s();
  ordered_json status = {{"elapsed_s", elapsed},
                         {"fraction", or_null(progress.fraction())},
                         {"remaining_s", or_null(progress.remaining_s())},
                         {"samples_per_s", or_null(tally_.rate(elapsed))}};
  status.update(tally_.to_json());
  return status;
}

int Runner::run(const std::function<int(RunOutcome&)>& finish) {
  mpi::TaskBoard board =
      state_.take_over(request_.output, request_.order, request_.retry_failed, world_);
  const bool idle = board.count(mpi::TaskState::waiting) == 0;
  if (host_) tally_.take_over(state_, board);
  if (host_ && !idle) {
    tell_warnings(builds_);
    keep_index();
  }
  core::Progress progress("build", board.total_cost(), !host_ || idle);
  progress.begin_at(board.settled_cost());
  const std::unique_ptr<StatusFile> status = status_file(idle, progress);
  try {
    return run_tasks(std::move(board), progress, status.get(), finish);
  } catch (...) {
    if (status) status->fail(std::current_exception());
    throw;
  }
}

int Runner::run_tasks(mpi::TaskBoard board, core::Progress& progress, StatusFile* status,
                      const std::function<int(RunOutcome&)>& finish) {
  const double expected = board.total_cost();
  LastWords last_words(index_.get(), [&](const std::vector<Results>& results, std::int64_t run) {
    if (status != nullptr) status->end("interrupted", mpi::exit_interrupted);
    if (request_.tell_interrupted) request_.tell_interrupted(results, run);
  });
  const mpi::InterruptGuard guard(last_words.leaving());
  std::optional<mpi::RunningTask> running;
  mpi::agreed(world_, [&] {
    running.emplace(running_file(request_.output, mpi::rank(world_)), mpi::exit_overdue);
  });
  mpi::RunReport report = mpi::run_tasks(
      world_, std::move(board), hooks(last_words, progress, expected, status),
      [&](std::int64_t number, MPI_Comm group) { return run_task(number, group, *running); },
      mpi::describe_machine(world_, builds_.front().build.config.ranks.memory_per_node));
  running.reset();
  last_words.keep();
  progress.finish(host_ ? tally_.text(progress.elapsed_s()) : "");
  if (status != nullptr) status->update(this->status(progress));

  outcome_.run = state_.run();
  outcome_.interrupted = report.interrupted;
  outcome_.ranks = plan::gather_times(report.times, world_);
  outcome_.calibration = std::move(report.calibration);
  write_results();
  const int code = std::stoi(mpi::broadcast(std::to_string(finish(outcome_)), 0, world_));
  if (status != nullptr) status->end(outcome_.interrupted ? "interrupted" : "done", code);
  return code;
}

}  // namespace

std::int64_t RunOutcome::tasks_run() const {
  std::int64_t sum = 0;
  for (const EndedBuild& build : builds) sum += build.tasks_run;
  return sum;
}

int run_builds(const RunRequest& request, MPI_Comm world,
               const std::function<int(RunOutcome&)>& finish) {
  return Runner(request, world).run(finish);
}

}  // namespace carillon::dataset::run
