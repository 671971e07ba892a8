#include "dataset/run/build.hpp"

#include <fmt/format.h>

#include <optional>

#include "core/error.hpp"
#include "dataset/plan/task_times.hpp"
#include "dataset/run/detail/last_words.hpp"
#include "dataset/run/keep_trace.hpp"
#include "dataset/run/run_builds.hpp"
#include "mpi/comm.hpp"
#include "mpi/folder_lock.hpp"

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
fs::path sweep_around(const fs::path& output, const mpi::Context& context) {
  std::string found;
  mpi::agreed(context.world, [&] {
    if (!context.speaks()) return;
    const fs::path inside = fs::absolute(output / "x").lexically_normal().parent_path();
    if (is_sweep(inside.parent_path())) found = inside.parent_path().string();
  });
  return mpi::broadcast(found, 0, context.world);
}

}  // namespace

int run_build(const BuildOptions& options, const mpi::Context& context) {
  return run_build(load_build(options, context.world), options, context);
}

int run_build(LoadedBuild build, const BuildOptions& options, const mpi::Context& context) {
  std::vector<BuildRun> builds(1);
  BuildRun& run = builds.front();
  run.build = std::move(build);
  const std::string output = options.output.empty() ? run.build.config.name : options.output;
  run.folders = {output, context.cache};
  std::optional<mpi::FolderLock> sweep_lock;
  if (const fs::path sweep = sweep_around(output, context); !sweep.empty()) {
    sweep_lock.emplace(sweep, context.world, lock_timeout_s);
  }
  const mpi::FolderLock lock(run.folders.output, context.world, lock_timeout_s);
  mpi::agreed(context.world, [&] {
    if (context.speaks()) refuse_sweep(output);
  });

  const auto summary_of = [&](const Results& results, std::int64_t tasks_run, bool interrupted) {
    return Summary{output,          run.build.plan.shapes.size(),
                   results.samples, tasks_run,
                   results.failed,  interrupted,
                   results.missed};
  };
  RunRequest request{builds, output, options.retry_failed};
  request.tell_interrupted = [&](const std::vector<Results>& results, std::int64_t tasks_run) {
    print(summary_of(results.front(), tasks_run, true), context.json);
  };
  return run_builds(request, context, [&](RunOutcome& outcome) {
    int exit_code = mpi::exit_done;
    mpi::agreed(context.world, [&] {
      if (!context.speaks()) return;
      const auto& [finished, tasks_run, results] = outcome.builds.front();
      const Summary summary = summary_of(results, tasks_run, outcome.interrupted);
      nlohmann::json trace = describe_trace(run.build, finished, results);
      keep_trace(output, trace, &outcome, context);
      if (summary.tasks_run > 0 && !context.json) {
        fmt::print("{}", plan::run_text(trace.at("runs").back()));
      }
      if (options.tell || outcome.interrupted) print(summary, context.json);
      exit_code = summary.exit_code();
    });
    return exit_code;
  });
}

}  // namespace carillon::dataset::run
