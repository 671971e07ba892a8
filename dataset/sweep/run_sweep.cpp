#include "dataset/sweep/run_sweep.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "dataset/run/keep_trace.hpp"
#include "dataset/run/run_builds.hpp"
#include "dataset/sweep/detail/results.hpp"
#include "dataset/sweep/detail/shared_work.hpp"
#include "dataset/sweep/detail/table.hpp"
#include "mpi/comm.hpp"
#include "mpi/exit_code.hpp"
#include "mpi/folder_lock.hpp"
#include "mpi/made_by.hpp"

namespace carillon::dataset::sweep {

using nlohmann::json;
using nlohmann::ordered_json;

namespace {

struct Ended {
  std::vector<ordered_json> results, timing;  ///< one per variant
};

/// Measures the sounds of every variant; the ranks take turns.
/// @param held  what each folder holds; the host's counts
std::vector<ordered_json> measure_variants(const std::vector<run::BuildRun>& runs,
                                           const std::vector<run::Results>& held, MPI_Comm world) {
  json counts = json::array();
  for (const run::Results& results : held) {
    counts.push_back({results.samples, results.failed, results.warnings, results.missed});
  }
  counts = json::parse(mpi::broadcast(counts.dump(), 0, world));
  const auto ranks = static_cast<std::size_t>(mpi::size(world));
  const auto rank = static_cast<std::size_t>(mpi::rank(world));
  ordered_json mine = ordered_json::array();
  mpi::agreed(world, [&] {
    for (std::size_t v = rank; v < runs.size(); v += ranks) {
      const run::Results results{counts[v][0], counts[v][1], counts[v][2], counts[v][3]};
      mine.push_back(variant_results(runs[v], results));
    }
  });
  std::vector<ordered_json> parts;
  for (const std::string& text : mpi::all_gather(mine.dump(), world)) {
    parts.push_back(ordered_json::parse(text));
  }
  std::vector<ordered_json> rows;
  for (std::size_t v = 0; v < runs.size(); ++v) rows.push_back(parts[v % ranks].at(v / ranks));
  return rows;
}

/// Calls and seconds of all variants together, and their tasks.
run::FolderTrace total_of(const std::vector<run::BuildRun>& runs,
                          const std::vector<run::FolderTrace>& traces) {
  run::FolderTrace total;
  for (std::size_t v = 0; v < runs.size(); ++v) {
    total.ran.merge(traces[v].ran);
    total.missed_pitch_targets += traces[v].missed_pitch_targets;
    for (plan::TaskRow row : traces[v].tasks) {
      row.task = runs[v].name + row.task;
      total.tasks.push_back(std::move(row));
    }
  }
  return total;
}

template <class T>
T sum_of(const std::vector<ordered_json>& rows, const char* name) {
  T sum = 0;
  for (const ordered_json& row : rows) sum += row.at(name).get<T>();
  return sum;
}

/// The columns that a person looks at first: results, then what they took.
std::vector<ordered_json> with_seconds(const Ended& ended) {
  std::vector<ordered_json> rows;
  for (std::size_t v = 0; v < ended.results.size(); ++v) {
    ordered_json row = ended.results[v];
    row.erase("audio_unit");
    for (const char* quiet : {"failed_tasks", "warnings", "missed_pitch_targets"}) {
      if (row.at(quiet) == 0) row[quiet] = nullptr;
    }
    for (const char* name : {"modes_s", "samples_s"}) {
      row[name] = fmt::format("{:.2f}", ended.timing[v].at(name).get<double>());
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

/// How a sweep's run went.
struct SweepEnd {
  const std::string& output;
  const LoadedSweep& loaded;
  std::int64_t tasks_run = 0;
  Ended ended{};
  std::string run_text{};  ///< what the run says of itself, if it ran tasks
};

void tell(const SweepEnd& end, const core::Tell& tell) {
  const auto& [output, loaded, tasks_run, ended, run_text] = end;
  const auto failed = sum_of<std::size_t>(ended.results, "failed_tasks");
  const auto samples = sum_of<std::size_t>(ended.results, "samples");
  ordered_json document = json_table(loaded.name, loaded.sweep, ended.results);
  document["output"] = output;
  document["samples"] = samples;
  document["tasks_run"] = tasks_run;
  document["failed_tasks"] = failed;
  document["interrupted"] = false;
  std::string text = run_text + text_table(loaded.sweep, with_seconds(ended));
  if (tasks_run == 0) {
    text += fmt::format("nothing to do: {} {} {} samples of {} variants\n", output,
                        failed > 0 ? "holds" : "is complete with", samples, ended.results.size());
  } else {
    text += fmt::format("{}: {} samples of {} variants, {} tasks run; sweep.csv holds the table\n",
                        output, samples, ended.results.size(), tasks_run);
  }
  if (const auto warnings = sum_of<std::size_t>(ended.results, "warnings"); warnings > 0)
    text += fmt::format("{} warnings: {}/*/warnings.json\n", warnings, output);
  if (failed > 0)
    text += fmt::format("{} failed tasks: {}/*/failures.json say why\n", failed, output);
  tell(text, document);
}

/// The tables are those of a sweep that is whole: they wait for it.
void tell_interrupted(const std::string& output, const std::vector<run::Results>& held,
                      std::int64_t tasks_run, const std::string& run_text, const core::Tell& tell) {
  if (!tell) return;
  std::size_t samples = 0, failed = 0;
  for (const run::Results& results : held) {
    samples += results.samples;
    failed += results.failed;
  }
  tell(run_text + fmt::format("{}: {} samples of {} variants, {} tasks run\n"
                              "interrupted: run the same command to go on\n",
                              output, samples, held.size(), tasks_run),
       json{{"output", output},
            {"samples", samples},
            {"tasks_run", tasks_run},
            {"failed_tasks", failed},
            {"interrupted", true}});
}

/// A folder is a sweep's or a dataset's.
void refuse_dataset(const std::filesystem::path& output) {
  if (!std::filesystem::exists(output / "configuration.yaml")) return;
  throw core::ConfigError(fmt::format("{} holds a dataset, not a sweep", output.string()),
                          "choose another folder with --output");
}

/// Writes what belongs into the folders; on the host.
/// @return what the run says of itself; "" where it ran nothing
std::string finish_folders(const std::vector<run::BuildRun>& runs, const run::RunOutcome& outcome,
                           const std::filesystem::path& output, const json& made) {
  std::vector<run::FolderTrace> traces;
  for (std::size_t v = 0; v < runs.size(); ++v) {
    const run::EndedBuild& ended = outcome.builds[v];
    traces.push_back(run::folder_trace(runs[v].build, ended.finished, ended.results));
    run::keep_trace(runs[v].folders.output, traces.back(), nullptr, made);
  }
  const auto ran = run::keep_trace(output, total_of(runs, traces), &outcome, made);
  return ran ? plan::run_text(*ran) : "";
}

/// sweep.json, from the beginning on: it says what the folder is.
void write_table(const LoadedSweep& loaded, const std::vector<ordered_json>& rows,
                 const std::filesystem::path& output) {
  core::write_text_durably(output / "sweep.json",
                           json_table(loaded.name, loaded.sweep, rows).dump(2) + "\n");
}

}  // namespace

int run_sweep(const LoadedSweep& loaded, const run::BuildOptions& options, MPI_Comm world) {
  const std::string output = options.output.empty() ? loaded.name : options.output;
  const std::filesystem::path folder(output);
  const bool host = mpi::rank(world) == 0;
  const mpi::FolderLock lock(folder, world, run::lock_timeout_s);
  mpi::agreed(world, [&] {
    if (!host) return;
    refuse_dataset(folder);
    write_table(loaded, std::vector(loaded.builds.size(), ordered_json::object()), folder);
  });
  // Without a cache of the user's the variants still share what they have in common.
  const std::filesystem::path cache =
      options.cache.empty() ? folder / "cache" : std::filesystem::path(options.cache);
  std::vector<run::BuildRun> runs;
  for (std::size_t v = 0; v < loaded.builds.size(); ++v) {
    const std::string& place = loaded.sweep.variants[v].folder;
    runs.push_back({loaded.builds[v], {folder / place, cache}, place + "/"});
  }
  run::RunRequest request{runs, folder, loaded.name, options.retry_failed};
  request.order = [&](run::CommonTasks& common) { return order_shared_work(runs, common); };
  request.tell_interrupted = [&](const std::vector<run::Results>& held, std::int64_t tasks_run) {
    tell_interrupted(output, held, tasks_run, "", options.tell_interrupted);
  };
  return run::run_builds(request, world, [&](run::RunOutcome& outcome) {
    SweepEnd end{output, loaded, outcome.tasks_run()};
    std::vector<run::Results> held;
    for (const run::EndedBuild& build : outcome.builds) held.push_back(build.results);
    mpi::agreed(world, [&] {
      if (!host) return;
      end.run_text = finish_folders(runs, outcome, folder, mpi::made_by(options.command, world));
    });
    if (outcome.interrupted) {
      if (host)
        tell_interrupted(output, held, end.tasks_run, end.run_text, options.tell_interrupted);
      return mpi::exit_interrupted;
    }
    end.ended.results = measure_variants(runs, held, world);
    mpi::agreed(world, [&] {
      if (!host) return;
      for (const run::EndedBuild& build : outcome.builds) {
        end.ended.timing.push_back(variant_timing(build.finished));
      }
      core::write_text_durably(folder / "sweep.csv", csv_table(loaded.sweep, end.ended.results));
      core::write_text_durably(folder / "sweep-timing.csv",
                               csv_table(loaded.sweep, end.ended.timing));
      write_table(loaded, end.ended.results, folder);
      if (options.tell) tell(end, options.tell);
    });
    return sum_of<std::size_t>(end.ended.results, "failed_tasks") > 0 ? mpi::exit_failures
                                                                      : mpi::exit_done;
  });
}

}  // namespace carillon::dataset::sweep
