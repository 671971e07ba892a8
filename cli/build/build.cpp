#include "cli/build/build.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <optional>

#include "cli/build/attempts.hpp"
#include "cli/build/check_files.hpp"
#include "cli/build/claim_folder.hpp"
#include "cli/build/costs.hpp"
#include "cli/build/index_keeper.hpp"
#include "cli/build/inputs.hpp"
#include "cli/build/last_words.hpp"
#include "cli/build/progress_so_far.hpp"
#include "cli/build/samples_task.hpp"
#include "cli/build/task_inputs.hpp"
#include "cli/build/task_times.hpp"
#include "core/files.hpp"
#include "core/progress.hpp"
#include "core/storage_error.hpp"
#include "mpi/comm.hpp"
#include "mpi/failure.hpp"
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

/// What a task ran, for the samples that it kept from an earlier run too.
core::Trace trace_of(const json& entry) {
  core::Trace sum;
  if (entry.contains("trace")) sum.merge(trace_from_json(entry.at("trace")));
  if (entry.contains("kept")) sum.merge(trace_from_json(entry.at("kept")));
  return sum;
}

/// What all finished tasks ran, in this run and in those before it.
core::Trace total_trace(const std::map<std::string, json>& finished) {
  core::Trace sum;
  for (const auto& [task, entry] : finished) {
    sum.merge(trace_of(entry));
  }
  return sum;
}

/// What earlier runs left: the folder is this build's from here on, without their leftovers.
Standing take_over(const LoadedBuild& build, const BuildFolders& folders,
                   const mpi::Journal& journal) {
  core::remove_leftovers(folders.output, true);
  if (!folders.cache.empty()) core::remove_leftovers(folders.cache, false);
  std::map<std::string, json> entries = finished_tasks(journal);
  claim_folder(build, folders.output, entries);
  keep_inputs(build.config, folders.output);
  drop_damaged(entries, folders.output);
  return sort_entries(build.config, build.plan, entries);
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
std::string run_task(const LoadedBuild& build, const TaskInputs& inputs, const BuildTask& task,
                     const std::map<std::string, std::size_t>& kept_samples,
                     const BuildFolders& folders, MPI_Comm group, mpi::Witness& witness) {
  const double start = core::monotonic_seconds();
  ModesTaskResult result;
  core::Trace own;
  watch_task(witness, build.config.limits, task.key, own, [&] {
    if (task.kind == TaskKind::modes) {
      result = run_modes_task(build.config, build.plan.shapes[task.shape], folders, group, own);
    } else {
      const auto kept = kept_samples.find(task.key);
      result.written = run_samples_task(build.config, build.plan, task, folders, own,
                                        kept == kept_samples.end() ? 0 : kept->second);
    }
  });
  json times = json::array();
  for (const std::string& file : result.written)
    times.push_back(modified_ns(folders.output / file));
  json record = {{"inputs", inputs.of(task)},
                 {"samples", task.count},
                 {"files", describe_files(result.written, folders.output)},
                 {"modified_ns", times},
                 {"seconds", core::monotonic_seconds() - start},
                 {"trace", to_json(own)}};
  if (!result.pitch_target.is_null()) record["pitch_target"] = result.pitch_target;
  return record.dump();
}

/// Ranks of a build that was killed take a few seconds to go.
constexpr double lock_patience_s = 10;

}  // namespace

int run_build(const BuildOptions& options, const Context& context) {
  const LoadedBuild build = load_build(options, context.world);
  const std::string output = options.output.empty() ? build.config.name : options.output;
  const BuildFolders folders{output, context.cache};
  const bool host = context.speaks();
  const mpi::FolderLock lock(folders.output, context.world, lock_patience_s);

  const TaskInputs inputs(build.config, build.plan);
  std::map<std::string, std::size_t> numbers;
  for (std::size_t t = 0; t < build.plan.tasks.size(); ++t) numbers[build.plan.tasks[t].key] = t;
  const auto inputs_of = [&](const std::string& task) {
    const auto found = numbers.find(task);
    return found == numbers.end() ? "" : inputs.of(build.plan.tasks[found->second]);
  };
  settle_attempts(folders.output / "journal.jsonl", folders.output, inputs_of, context.world);
  std::unique_ptr<mpi::Journal> journal;
  Standing standing;
  mpi::TaskBoard board;
  int run = 1;
  mpi::agreed(context.world, [&] {
    if (!host) return;
    journal = std::make_unique<mpi::Journal>(folders.output / "journal.jsonl");
    standing = take_over(build, folders, *journal);
    run = next_run(journal->entries());
    board = make_board(build, standing.finished, options.retry_failed);
  });
  std::map<std::string, std::size_t> kept_samples;
  for (const auto& [task, entry] : standing.grown) kept_samples[task] = entry.at("samples");
  kept_samples = json::parse(mpi::broadcast(json(kept_samples).dump(), 0, context.world))
                     .get<std::map<std::string, std::size_t>>();
  const bool idle = board.count(mpi::TaskState::waiting) == 0;
  if (host && !idle) {
    for (const std::string& warning : build.config.warnings) spdlog::warn("{}", warning);
  }

  const double expected = board.total_cost();
  core::Progress progress("build", expected, context.quiet || context.json || !host || idle);
  std::unique_ptr<IndexKeeper> index;
  if (host && !idle) index = std::make_unique<IndexKeeper>(build, folders, standing.finished);
  LastWords last_words(index.get(), {output, build.plan.shapes.size()}, context.json);
  mpi::ServiceHooks hooks;
  hooks.completed = [&](const mpi::Task& task, const mpi::Outcome& outcome) {
    json entry = json::parse(outcome.record);
    // A full disk is nobody's failure: nothing is recorded, and the run ends.
    if (entry.value("kind", "") == "StorageError") {
      throw core::StorageError(entry.at("message"), entry.value("hint", ""));
    }
    entry["task"] = task.key;
    entry["ok"] = outcome.ok;
    entry["times"] = describe_times(task, outcome.times, run);
    if (!outcome.ok) entry["inputs"] = inputs_of(task.key);
    if (const auto old = standing.grown.find(task.key); outcome.ok && old != standing.grown.end()) {
      entry["kept"] = to_json(trace_of(old->second));
    }
    last_words.count([&] {
      journal->append(entry);
      index->add(entry);
    });
    standing.finished[task.key] = std::move(entry);
  };
  hooks.progress = [&](const mpi::TaskBoard& now) {
    // Costs grow and shrink as tasks tell how long they take.
    progress.update(
        expected * now.settled_cost() / std::max(now.total_cost(), 1e-300),
        fmt::format("{} of {} tasks", now.count(mpi::TaskState::done), now.tasks().size()));
  };
  const mpi::InterruptGuard guard(last_words.leaving());
  std::optional<mpi::Witness> witness;
  mpi::agreed(context.world, [&] {
    witness.emplace(witness_file(folders.output, mpi::rank(context.world)),
                    mpi::size(context.world), exit_interrupted);
  });
  const mpi::RunReport report = mpi::run_tasks(
      context.world, std::move(board), hooks,
      [&](std::int64_t number, MPI_Comm group) {
        return run_task(build, inputs, build.plan.tasks[static_cast<std::size_t>(number)],
                        kept_samples, folders, group, *witness);
      },
      mpi::describe_machine(context.world, build.config.ranks.memory_per_node));
  witness.reset();
  last_words.keep();
  if (index) index->end();
  progress.finish("");

  const std::vector<mpi::RankTimes> ranks = gather_times(report.times, context.world);
  int exit_code = exit_done;
  mpi::agreed(context.world, [&] {
    if (!host) return;
    const auto& finished = standing.finished;
    const Results results = write_results(build, folders, finished);
    const Summary summary{
        output,         build.plan.shapes.size(), results.samples, last_words.tasks_run(),
        results.failed, report.interrupted,       results.missed};
    if (summary.tasks_run > 0) {
      json document = to_json(total_trace(finished));
      document["configuration_folder"] = configuration_folder(build.path);
      document["missed_pitch_targets"] = results.missed.size();
      document["tasks"] = task_rows(finished);
      document["index"] = {{"calls", index->cost().calls}, {"seconds", index->cost().seconds}};
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
