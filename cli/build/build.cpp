#include "cli/build/build.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <optional>

#include "cli/build/attempts.hpp"
#include "cli/build/costs.hpp"
#include "cli/build/inputs.hpp"
#include "cli/build/progress_so_far.hpp"
#include "cli/build/samples_task.hpp"
#include "cli/build/task_times.hpp"
#include "core/files.hpp"
#include "core/progress.hpp"
#include "mpi/comm.hpp"
#include "mpi/folder_lock.hpp"
#include "mpi/interrupt.hpp"
#include "mpi/task_service.hpp"
#include "mpi/witness.hpp"

namespace carillon::cli {

using nlohmann::json;

namespace {

json entries_json(const std::map<std::string, core::Trace::Entry>& entries) {
  json out = json::object();
  for (const auto& [name, entry] : entries) {
    out[name] = {{"calls", entry.calls}, {"seconds", entry.seconds}};
  }
  return out;
}

json to_json(const core::Trace& trace) {
  return {{"stages", entries_json(trace.stages)}, {"effects", entries_json(trace.effects)}};
}

void read_entries(const json& from, std::map<std::string, core::Trace::Entry>& to) {
  for (const auto& [name, entry] : from.items()) {
    to[name] = {entry.at("calls").get<std::int64_t>(), entry.at("seconds").get<double>()};
  }
}

core::Trace trace_from_json(const json& document) {
  core::Trace trace;
  read_entries(document.at("stages"), trace.stages);
  read_entries(document.at("effects"), trace.effects);
  return trace;
}

/// What all finished tasks ran, in this run and in those before it.
core::Trace total_trace(const std::map<std::string, json>& finished) {
  core::Trace sum;
  for (const auto& [task, entry] : finished) {
    if (entry.contains("trace")) sum.merge(trace_from_json(entry.at("trace")));
  }
  return sum;
}

/// The board of all tasks, with those that an earlier run settled marked.
mpi::TaskBoard make_board(const LoadedBuild& build, const std::map<std::string, json>& finished,
                          bool retry_failed) {
  mpi::TaskBoard board(board_tasks(build.plan, build.config));
  const auto settled = [&](std::size_t task, bool ok) {
    const auto found = finished.find(build.plan.tasks[task].key);
    return found != finished.end() && found->second.at("ok").get<bool>() == ok;
  };
  // What is done comes first: it stays done whatever became of what it needed.
  const std::size_t tasks = build.plan.tasks.size();
  for (std::size_t t = 0; t < tasks; ++t) {
    if (settled(t, true)) board.mark_done(static_cast<std::int64_t>(t));
  }
  for (std::size_t t = 0; t < tasks && !retry_failed; ++t) {
    if (settled(t, false)) board.mark_failed(static_cast<std::int64_t>(t));
  }
  return board;
}

/// One task on the ranks of a group; returns its journal record.
std::string run_task(const LoadedBuild& build, const BuildTask& task, const BuildFolders& folders,
                     MPI_Comm group, mpi::Witness& witness) {
  const double start = core::monotonic_seconds();
  ModesTaskResult result;
  core::Trace own;
  watch_task(witness, build.config.limits, task.key, own, [&] {
    if (task.kind == TaskKind::modes) {
      result = run_modes_task(build.config, build.plan.shapes[task.shape], folders, group, own);
    } else {
      result.written = run_samples_task(build.config, build.plan, task, folders, own);
    }
  });
  json record = {{"files", describe_files(result.written, folders.output)},
                 {"seconds", core::monotonic_seconds() - start},
                 {"trace", to_json(own)}};
  if (!result.pitch_target.is_null()) record["pitch_target"] = result.pitch_target;
  return record.dump();
}

/// What a finished or interrupted build says.
struct Summary {
  std::string output;
  std::size_t shapes = 0, samples = 0;
  std::int64_t tasks_run = 0;
  std::size_t failed = 0;
  bool interrupted = false;
  std::vector<std::string> missed;  ///< shapes that did not meet the pitch target

  int exit_code() const {
    return interrupted ? exit_interrupted : failed > 0 ? exit_failures : exit_done;
  }
};

void print(const Summary& summary, bool as_json) {
  if (as_json) {
    fmt::print("{}\n", json{{"output", summary.output},
                            {"shapes", summary.shapes},
                            {"samples", summary.samples},
                            {"tasks_run", summary.tasks_run},
                            {"failed_tasks", summary.failed},
                            {"missed_pitch_targets", summary.missed},
                            {"interrupted", summary.interrupted}}
                           .dump(2));
    return;
  }
  if (summary.tasks_run == 0 && !summary.interrupted) {
    fmt::print("nothing to do: {} {} {} samples of {} shapes\n", summary.output,
               summary.failed > 0 ? "holds" : "is complete with", summary.samples, summary.shapes);
  } else {
    fmt::print("{}: {} samples of {} shapes, {} tasks run\n", summary.output, summary.samples,
               summary.shapes, summary.tasks_run);
  }
  if (summary.interrupted) fmt::print("interrupted: run the same command to go on\n");
  if (!summary.missed.empty()) {
    fmt::print("{} of {} shapes missed the pitch target: dataset.json says by how much\n",
               summary.missed.size(), summary.shapes);
  }
  if (summary.failed > 0) {
    fmt::print("{} failed tasks: {}/failures.json says why\n", summary.failed, summary.output);
  }
}

}  // namespace

int run_build(const BuildOptions& options, const Context& context) {
  const LoadedBuild build = load_build(options, context.world);
  const std::string output = options.output.empty() ? build.config.name : options.output;
  const BuildFolders folders{output, context.cache};
  const bool host = context.speaks();
  const mpi::FolderLock lock(folders.output, context.world);

  settle_attempts(folders.output / "journal.jsonl", folders.output, context.world);
  std::unique_ptr<mpi::Journal> journal;
  mpi::TaskBoard board;
  int run = 1;
  mpi::agreed(context.world, [&] {
    if (!host) return;
    journal = std::make_unique<mpi::Journal>(folders.output / "journal.jsonl");
    claim_folder(build, folders.output);
    keep_inputs(build.config, folders.output);
    run = next_run(journal->entries());
    board = make_board(build, finished_tasks(*journal, folders.output), options.retry_failed);
  });
  const bool idle = board.count(mpi::TaskState::waiting) == 0;
  if (host && !idle) {
    for (const std::string& warning : build.config.warnings) spdlog::warn("{}", warning);
  }
  std::int64_t tasks_run = 0;

  const double expected = board.total_cost();
  core::Progress progress("build", expected, context.quiet || context.json || !host || idle);
  mpi::ServiceHooks hooks;
  hooks.completed = [&](const mpi::Task& task, const mpi::Outcome& outcome) {
    json entry = json::parse(outcome.record);
    entry["task"] = task.key;
    entry["ok"] = outcome.ok;
    entry["times"] = describe_times(task, outcome.times, run);
    journal->append(entry);
    ++tasks_run;
  };
  hooks.progress = [&](const mpi::TaskBoard& now) {
    // Costs grow and shrink as tasks tell how long they take.
    progress.update(
        expected * now.settled_cost() / std::max(now.total_cost(), 1e-300),
        fmt::format("{} of {} tasks", now.count(mpi::TaskState::done), now.tasks().size()));
  };
  const mpi::InterruptGuard guard;
  std::optional<mpi::Witness> witness;
  mpi::agreed(context.world, [&] {
    witness.emplace(idle ? "" : witness_file(folders.output, mpi::rank(context.world)),
                    mpi::size(context.world), exit_interrupted);
  });
  const mpi::RunReport report = mpi::run_tasks(
      context.world, std::move(board), hooks,
      [&](std::int64_t number, MPI_Comm group) {
        return run_task(build, build.plan.tasks[static_cast<std::size_t>(number)], folders, group,
                        *witness);
      },
      mpi::describe_machine(context.world, build.config.ranks.memory_per_node));
  witness.reset();
  progress.finish("");

  const std::vector<mpi::RankTimes> ranks = gather_times(report.times, context.world);
  int exit_code = exit_done;
  mpi::agreed(context.world, [&] {
    if (!host) return;
    journal = std::make_unique<mpi::Journal>(folders.output / "journal.jsonl");
    const auto finished = finished_tasks(*journal, folders.output);
    const Results results = write_results(build, folders, finished);
    const Summary summary{output,         build.plan.shapes.size(), results.samples, tasks_run,
                          results.failed, report.interrupted,       results.missed};
    if (tasks_run > 0) {
      json document = to_json(total_trace(finished));
      document["configuration_folder"] = configuration_folder(build.path);
      document["missed_pitch_targets"] = results.missed.size();
      document["tasks"] = task_rows(finished);
      document["runs"] = earlier_runs(folders.output / "trace.json");
      document["runs"].push_back(describe_run(run, ranks, report.calibration, document["tasks"]));
      document["ranks"] = document["runs"].back().at("ranks");
      if (!context.json) fmt::print("{}", run_text(document["runs"].back()));
      core::write_text_durably(folders.output / "trace.json", document.dump(2) + "\n");
    }
    print(summary, context.json);
    exit_code = summary.exit_code();
  });
  return std::stoi(mpi::broadcast(std::to_string(exit_code), 0, context.world));
}

}  // namespace carillon::cli
