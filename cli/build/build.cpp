#include "cli/build/build.hpp"

#include <fmt/format.h>

#include "cli/build/last_words.hpp"
#include "cli/build/run_builds.hpp"
#include "cli/build/task_times.hpp"
#include "core/error.hpp"
#include "mpi/comm.hpp"
#include "mpi/folder_lock.hpp"

namespace carillon::cli {

namespace {

/// A folder is a dataset's or a sweep's.
void refuse_sweep(const std::filesystem::path& output) {
  if (!std::filesystem::exists(output / "sweep.json")) return;
  throw core::ConfigError(fmt::format("{} holds a sweep, not a dataset", output.string()),
                          "choose another folder with --output");
}

}  // namespace

int run_build(const BuildOptions& options, const Context& context) {
  std::vector<BuildRun> builds(1);
  BuildRun& run = builds.front();
  run.build = load_build(options, context.world);
  const std::string output = options.output.empty() ? run.build.config.name : options.output;
  run.folders = {output, context.cache};
  mpi::agreed(context.world, [&] {
    if (context.speaks()) refuse_sweep(output);
  });
  const mpi::FolderLock lock(run.folders.output, context.world, lock_patience_s);

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
    int exit_code = exit_done;
    mpi::agreed(context.world, [&] {
      if (!context.speaks()) return;
      const auto& finished = outcome.builds.front().finished;
      const Results results = write_results(run.build, run.folders, finished);
      const Summary summary = summary_of(results, outcome.tasks_run(), outcome.interrupted);
      if (summary.tasks_run > 0) {
        nlohmann::json document = describe_trace(run.build, finished, results);
        add_run(document, outcome, output);
        if (!context.json) fmt::print("{}", run_text(document.at("runs").back()));
        write_trace(output, document);
      }
      print(summary, context.json);
      exit_code = summary.exit_code();
    });
    return exit_code;
  });
}

}  // namespace carillon::cli
