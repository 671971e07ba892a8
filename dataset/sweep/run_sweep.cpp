#include "dataset/sweep/run_sweep.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "dataset/plan/task_times.hpp"
#include "dataset/run/keep_trace.hpp"
#include "dataset/run/run_builds.hpp"
#include "dataset/run/trace_json.hpp"
#include "dataset/sweep/detail/results.hpp"
#include "dataset/sweep/detail/shared_work.hpp"
#include "dataset/sweep/detail/table.hpp"
#include "mpi/comm.hpp"
#include "mpi/folder_lock.hpp"

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
                                           std::vector<run::Results> held,
                                           const mpi::Context& context) {
  json counts = json::array();
  for (const run::Results& results : held) {
    counts.push_back({results.samples, results.failed, results.missed});
  }
  counts = json::parse(mpi::broadcast(counts.dump(), 0, context.world));
  const auto ranks = static_cast<std::size_t>(mpi::size(context.world));
  const auto rank = static_cast<std::size_t>(mpi::rank(context.world));
  ordered_json mine = ordered_json::array();
  mpi::agreed(context.world, [&] {
    for (std::size_t v = rank; v < runs.size(); v += ranks) {
      const run::Results results{counts[v][0], counts[v][1], counts[v][2]};
      mine.push_back(variant_results(runs[v], results));
    }
  });
  std::vector<ordered_json> parts;
  for (const std::string& text : mpi::all_gather(mine.dump(), context.world)) {
    parts.push_back(ordered_json::parse(text));
  }
  std::vector<ordered_json> rows;
  for (std::size_t v = 0; v < runs.size(); ++v) rows.push_back(parts[v % ranks].at(v / ranks));
  return rows;
}

/// Calls and seconds of all variants together, and their tasks.
json total_of(const std::vector<run::BuildRun>& runs, const std::vector<json>& traces,
              const run::RunOutcome& outcome) {
  core::Trace sum;
  json tasks = json::array();
  std::size_t missed = 0;
  for (std::size_t v = 0; v < runs.size(); ++v) {
    sum.merge(run::total_trace(outcome.builds[v].finished));
    missed += traces[v].at("missed_pitch_targets").get<std::size_t>();
    for (json row : traces[v].at("tasks")) {
      row["task"] = runs[v].name + row.at("task").get<std::string>();
      tasks.push_back(std::move(row));
    }
  }
  json total = run::to_json(sum);
  total["missed_pitch_targets"] = missed;
  total["tasks"] = std::move(tasks);
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
    for (const char* quiet : {"failed_tasks", "missed_pitch_targets"}) {
      if (row.at(quiet) == 0) row[quiet] = nullptr;
    }
    for (const char* name : {"modes_s", "samples_s"}) {
      row[name] = fmt::format("{:.2f}", ended.timing[v].at(name).get<double>());
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

void print(const std::string& output, const LoadedSweep& loaded, const Ended& ended,
           std::int64_t tasks_run, bool as_json) {
  const auto failed = sum_of<std::size_t>(ended.results, "failed_tasks");
  const auto samples = sum_of<std::size_t>(ended.results, "samples");
  if (as_json) {
    ordered_json document = json_table(loaded.name, loaded.sweep, ended.results);
    document["output"] = output;
    document["samples"] = samples;
    document["tasks_run"] = tasks_run;
    document["failed_tasks"] = failed;
    document["interrupted"] = false;
    fmt::print("{}\n", document.dump(2));
    return;
  }
  fmt::print("{}", text_table(loaded.sweep, with_seconds(ended)));
  if (tasks_run == 0) {
    fmt::print("nothing to do: {} {} {} samples of {} variants\n", output,
               failed > 0 ? "holds" : "is complete with", samples, ended.results.size());
  } else {
    fmt::print("{}: {} samples of {} variants, {} tasks run; sweep.csv holds the table\n", output,
               samples, ended.results.size(), tasks_run);
  }
  if (failed > 0) fmt::print("{} failed tasks: {}/*/failures.json say why\n", failed, output);
}

/// The tables are those of a sweep that is whole: they wait for it.
void print_interrupted(const std::string& output, const std::vector<run::Results>& held,
                       std::int64_t tasks_run, bool as_json) {
  std::size_t samples = 0, failed = 0;
  for (const run::Results& results : held) {
    samples += results.samples;
    failed += results.failed;
  }
  if (as_json) {
    fmt::print("{}\n", json{{"output", output},
                            {"samples", samples},
                            {"tasks_run", tasks_run},
                            {"failed_tasks", failed},
                            {"interrupted", true}}
                           .dump(2));
    return;
  }
  fmt::print("{}: {} samples of {} variants, {} tasks run\n", output, samples, held.size(),
             tasks_run);
  fmt::print("interrupted: run the same command to go on\n");
}

/// A folder is a sweep's or a dataset's.
void refuse_dataset(const std::filesystem::path& output) {
  if (!std::filesystem::exists(output / "configuration.yaml")) return;
  throw core::ConfigError(fmt::format("{} holds a dataset, not a sweep", output.string()),
                          "choose another folder with --output");
}

/// Writes what belongs into the folders and says how it went; on the host.
/// @return what each folder holds
std::vector<run::Results> finish_folders(const std::vector<run::BuildRun>& runs,
                                         const run::RunOutcome& outcome,
                                         const std::filesystem::path& output,
                                         const mpi::Context& context) {
  std::vector<run::Results> held;
  std::vector<json> traces;
  for (std::size_t v = 0; v < runs.size(); ++v) {
    const run::EndedBuild& ended = outcome.builds[v];
    held.push_back(ended.results);
    traces.push_back(run::describe_trace(runs[v].build, ended.finished, held.back()));
    run::keep_trace(runs[v].folders.output, traces.back(), nullptr, context);
  }
  json total = total_of(runs, traces, outcome);
  run::keep_trace(output, total, &outcome, context);
  if (outcome.tasks_run() > 0 && !context.json)
    fmt::print("{}", plan::run_text(total.at("runs").back()));
  return held;
}

/// sweep.json, from the beginning on: it says what the folder is.
void write_table(const LoadedSweep& loaded, const std::vector<ordered_json>& rows,
                 const std::filesystem::path& output) {
  core::write_text_durably(output / "sweep.json",
                           json_table(loaded.name, loaded.sweep, rows).dump(2) + "\n");
}

}  // namespace

int run_sweep(const LoadedSweep& loaded, const run::BuildOptions& options,
              const mpi::Context& context) {
  const std::filesystem::path output(options.output.empty() ? loaded.name : options.output);
  const bool host = context.speaks();
  const mpi::FolderLock lock(output, context.world, run::lock_timeout_s);
  mpi::agreed(context.world, [&] {
    if (!host) return;
    refuse_dataset(output);
    write_table(loaded, std::vector(loaded.builds.size(), ordered_json::object()), output);
  });
  // Without a cache of the user's the variants still share what they have in common.
  const std::filesystem::path cache =
      context.cache.empty() ? output / "cache" : std::filesystem::path(context.cache);
  std::vector<run::BuildRun> runs;
  for (std::size_t v = 0; v < loaded.builds.size(); ++v) {
    const std::string& folder = loaded.sweep.variants[v].folder;
    runs.push_back({loaded.builds[v], {output / folder, cache}, folder + "/"});
  }
  run::RunRequest request{runs, output, options.retry_failed};
  request.order = [&](run::CommonTasks& common) { return order_shared_work(runs, common); };
  request.tell_interrupted = [&](const std::vector<run::Results>& held, std::int64_t tasks_run) {
    print_interrupted(output.string(), held, tasks_run, context.json);
  };
  return run::run_builds(request, context, [&](run::RunOutcome& outcome) {
    std::vector<run::Results> held;
    mpi::agreed(context.world, [&] {
      if (host) held = finish_folders(runs, outcome, output, context);
    });
    if (outcome.interrupted) {
      if (host) print_interrupted(output.string(), held, outcome.tasks_run(), context.json);
      return mpi::exit_interrupted;
    }
    Ended ended{measure_variants(runs, held, context), {}};
    mpi::agreed(context.world, [&] {
      if (!host) return;
      for (const run::EndedBuild& build : outcome.builds) {
        ended.timing.push_back(variant_timing(build.finished));
      }
      core::write_text_durably(output / "sweep.csv", csv_table(loaded.sweep, ended.results));
      core::write_text_durably(output / "sweep-timing.csv", csv_table(loaded.sweep, ended.timing));
      write_table(loaded, ended.results, output);
      if (options.tell) print(output.string(), loaded, ended, outcome.tasks_run(), context.json);
    });
    return sum_of<std::size_t>(ended.results, "failed_tasks") > 0 ? mpi::exit_failures
                                                                  : mpi::exit_done;
  });
}

}  // namespace carillon::dataset::sweep
