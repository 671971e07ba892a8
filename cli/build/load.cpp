#include "cli/build/build.hpp"
#include "core/error.hpp"
#include "mpi/comm.hpp"

namespace carillon::cli {

LoadedBuild load_build(const BuildOptions& options, MPI_Comm world) {
  std::string text;
  mpi::agreed(world, [&] {
    if (mpi::rank(world) == 0) text = core::read_text_file(options.config);
  });
  text = mpi::broadcast(text, 0, world);
  LoadedBuild build;
  build.path = options.config;
  build.overrides = options.overrides;
  mpi::agreed(world, [&] {
    build.config = read_build_config(text, options.config, options.overrides);
    build.plan = make_plan(build.config);
  });
  const auto plans = mpi::all_gather(fingerprint(build.config, build.plan), world);
  for (const std::string& plan : plans) {
    if (plan != plans.front()) {
      throw core::InputError("the ranks do not see the same files",
                             "the folders of the configuration must be on a shared file system");
    }
  }
  return build;
}

}  // namespace carillon::cli
