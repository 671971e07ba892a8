#include "dataset/run/build.hpp"

#include <fmt/format.h>

#include <optional>

#include "core/error.hpp"
#include "dataset/run/keep_trace.hpp"
#include "dataset/run/run_builds.hpp"
#include "mpi/comm.hpp"
#include "mpi/exit_code.hpp"
#include "mpi/folder_lock.hpp"
#include "mpi/made_by.hpp"

namespace carillon::dataset::run {

namespace {

namespace fs = std::filesystem;

bool is_sweep(const fs::path& folder) {
  return fs::exists(folder / "sweep.json");
}

/// A folder is a dataset's or a sweep's.
void refuse_sweep(const fs::path& output) {
  if (!is_sweep(output)) return;
  throw core::ConfigError(fmt::format("{} holds a sweep, not a dataset", output.string()),
                          "choose another folder with --output");
}

/// The sweep that a folder is a variant of; "" where it is none. The same on every rank.
fs::path sweep_around(const fs::path& output, MPI_Comm world) {
  std::string found;
  mpi::agreed(world, [&] {
    if (mpi::rank(world) != 0) return;
    const fs::path inside = fs::absolute(output / "x").lexically_normal().parent_path();
    if (is_sweep(inside.parent_path())) found = inside.parent_path().string();
  });
  return mpi::broadcast(found, 0, world);
}

/// What a finished or interrupted build says.
struct Summary {
  std::string output;
  std::size_t shapes = 0;
  Results results{};
  std::int64_t tasks_run = 0;
  bool interrupted = false;
};

nlohmann::json to_json(const Summary& summary) {
  return {{"output", summary.output},
          {"shapes", summary.shapes},
          {"samples", summary.results.samples},
          {"tasks_run", summary.tasks_run},
          {"failed_tasks", summary.results.failed},
          {"warnings", summary.results.warnings},
          {"missed_pitch_targets", summary.results.missed},
          {"interrupted", summary.interrupted}};
}

std::string summary_text(const Summary& summary) {
  const auto& [output, shapes, results, tasks_run, interrupted] = summary;
  std::string text =
      tasks_run == 0 && !interrupted
          ? fmt::format("nothing to do: {} {} {} samples of {} shapes\n", output,
                        results.failed > 0 ? "holds" : "is complete with", results.samples, shapes)
          : fmt::format("{}: {} samples of {} shapes, {} tasks run\n", output, results.samples,
                        shapes, tasks_run);
  if (interrupted) text += "interrupted: run the same command to go on\n";
  if (!results.missed.empty()) {
    text += fmt::format("{} of {} shapes missed the pitch target: dataset.json says by how much\n",
                        results.missed.size(), shapes);
  }
  if (results.warnings > 0)
    text += fmt::format("{} warnings: {}/warnings.json\n", results.warnings, output);
  if (results.failed > 0) {
    text += fmt::format("{} failed tasks: {}/failures.json says why\n", results.failed, output);
  }
  return text;
}

}  // namespace

int run_build(LoadedBuild build, const BuildOptions& options, MPI_Comm world) {
  std::vector<BuildRun> builds(1);
  BuildRun& run = builds.front();
  run.build = std::move(build);
  const std::string output = options.output.empty() ? run.build.config.name : options.output;
  run.folders = {output, options.cache};
  std::optional<mpi::FolderLock> sweep_lock;
  if (const fs::path sweep = sweep_around(output, world); !sweep.empty()) {
    sweep_lock.emplace(sweep, world, lock_timeout_s);
  }
  const mpi::FolderLock lock(run.folders.output, world, lock_timeout_s);
  const bool host = mpi::rank(world) == 0;
  mpi::agreed(world, [&] {
    if (host) refuse_sweep(output);
  });

  const std::size_t shapes = run.build.plan.shapes.size();
  RunRequest request{builds, output, run.build.config.name, options.retry_failed};
  request.tell_interrupted = [&](const std::vector<Results>& results, std::int64_t tasks_run) {
    const Summary summary{output, shapes, results.front(), tasks_run, true};
    if (options.tell_interrupted) options.tell_interrupted(summary_text(summary), to_json(summary));
  };
  return run_builds(request, world, [&](RunOutcome& outcome) {
    int exit_code = mpi::exit_done;
    mpi::agreed(world, [&] {
      if (!host) return;
      const auto& [finished, tasks_run, results] = outcome.builds.front();
      const Summary summary{output, shapes, results, tasks_run, outcome.interrupted};
      const auto ran = keep_trace(output, folder_trace(run.build, finished, results), &outcome,
                                  mpi::made_by(options.command, world));
      const core::Tell& tell = outcome.interrupted ? options.tell_interrupted : options.tell;
      if (tell) tell((ran ? plan::run_text(*ran) : "") + summary_text(summary), to_json(summary));
      exit_code = outcome.interrupted  ? mpi::exit_interrupted
                  : results.failed > 0 ? mpi::exit_failures
                                       : mpi::exit_done;
    });
    return exit_code;
  });
}

}  // namespace carillon::dataset::run
