// What writing the index costs: the figures of docs/scaling.md, Where the next limits are.
#include <fmt/core.h>

#include <ctime>
#include <filesystem>

#include "core/files.hpp"
#include "core/trace.hpp"
#include "dataset/run/build.hpp"
#include "dataset/run/progress_so_far.hpp"
#include "mpi/journal.hpp"

namespace {

using namespace carillon;

/// Writes index, description and failures of a finished dataset anew, as they are.
void time_index(const std::filesystem::path& folder) {
  carillon::dataset::run::BuildOptions options;
  options.config = (folder / "configuration.yaml").string();
  carillon::dataset::run::LoadedBuild build =
      carillon::dataset::run::read_build(core::read_file(options.config), options);
  build.plan = carillon::dataset::plan::make_plan(build.config);
  const auto finished =
      carillon::dataset::run::finished_tasks(mpi::read_journal(folder / "journal.jsonl").entries);
  const carillon::dataset::samples::BuildFolders folders{folder, ""};
  std::size_t shards = 0;
  for (const carillon::dataset::plan::BuildTask& task : build.plan.tasks)
    shards += task.kind == carillon::dataset::plan::TaskKind::samples ? 1 : 0;

  carillon::dataset::run::JoinedFiles joined(folder);
  const auto timed = [&](const char* what) {
    const double start = core::monotonic_seconds();
    const std::clock_t processor = std::clock();
    const std::size_t samples =
        carillon::dataset::run::write_results(build, folders, finished, joined).samples;
    const double computing = double(std::clock() - processor) / CLOCKS_PER_SEC;
    fmt::print(
        "{:<28} {} shards, {} samples: {:.3f} s, of which a processor computes {:.3f} s, {:.3f} "
        "ms a shard\n",
        what, shards, samples, core::monotonic_seconds() - start, computing,
        1e3 * computing / static_cast<double>(shards));
  };
  timed("first, every file is read");
  timed("again, all files are known");
  timed("again, all files are known");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: bench index DATASET\n");
    return 2;
  }
  time_index(argv[1]);
  return 0;
}
