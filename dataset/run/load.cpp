#include "core/error.hpp"
#include "dataset/run/build.hpp"
#include "dataset/run/shared_meshes.hpp"
#include "mpi/comm.hpp"

namespace carillon::dataset::run {

std::string shared_text(const std::string& path, MPI_Comm world) {
  std::string text;
  mpi::agreed(world, [&] {
    if (mpi::rank(world) == 0) text = core::read_text_file(path);
  });
  return mpi::broadcast(text, 0, world);
}

std::string shared_text(const BuildOptions& options, MPI_Comm world) {
  return options.text ? *options.text : shared_text(options.config, world);
}

void check_alike(const std::string& fingerprint, MPI_Comm world) {
  const auto plans = mpi::all_gather(fingerprint, world);
  for (const std::string& plan : plans) {
    if (plan != plans.front()) {
      throw core::InputError("the ranks do not see the same files",
                             "the folders of the configuration must be on a shared file system");
    }
  }
}

LoadedBuild read_build(const std::string& text, const BuildOptions& options) {
  LoadedBuild build;
  build.path = options.config;
  build.overrides = options.overrides;
  build.config = configuration::read_build_config(text, options.config, options.overrides);
  return build;
}

LoadedBuild load_build(const BuildOptions& options, MPI_Comm world) {
  const std::string text = shared_text(options, world);
  LoadedBuild build;
  mpi::agreed(world, [&] { build = read_build(text, options); });
  const SharedMeshes meshes({&build, 1}, world);
  mpi::agreed(world, [&] { build.plan = plan::make_plan(build.config, meshes.of(build.config)); });
  check_alike(plan::fingerprint(build.config, build.plan), world);
  return build;
}

}  // namespace carillon::dataset::run
