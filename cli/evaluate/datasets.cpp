#include "cli/evaluate/datasets.hpp"

#include <fmt/ranges.h>

#include "cli/build/run_builds.hpp"
#include "cli/sweep/run_sweep.hpp"
#include "core/config.hpp"
#include "mpi/comm.hpp"

namespace carillon::cli {

namespace {

/// A dataset that is there.
struct GivenFolder {
  std::string name;  ///< the configuration's
  std::string folder;
};

/// What a configuration with a key `data` names.
std::optional<GivenFolder> given_folder(const BuildOptions& options, MPI_Comm world) {
  const std::string text = shared_text(options.config, world);
  std::optional<GivenFolder> given;
  mpi::agreed(world, [&] {
    core::ConfigNode root = core::ConfigNode::parse(text, options.config, options.overrides);
    if (!root.has("data")) return;
    given.emplace();
    given->name = root.text("name", std::filesystem::path(options.config).stem().string());
    given->folder = core::path_beside(options.config, root.text("data"));
    root.leave_alone({"train", "evaluate"});
    root.finish();
    if (!std::filesystem::exists(std::filesystem::path(given->folder) / "index.h5")) {
      root.fail("data", fmt::format("{} is no dataset: it has no index.h5", given->folder),
                "give the folder that carillon build wrote");
    }
  });
  return given;
}

}  // namespace

EvaluatedDatasets::EvaluatedDatasets(const BuildOptions& options, MPI_Comm world)
    : options_(options) {
  if (const auto given = given_folder(options, world)) {
    name_ = given->name;
    output_ = options.output.empty() ? name_ : options.output;
    conditions_.push_back({.name = name_, .folder = given->folder});
  } else {
    plan(world);
  }
}

void EvaluatedDatasets::plan(MPI_Comm world) {
  sweep_ = load_sweep(options_, world);
  if (!sweep_) build_ = load_build(options_, world);
  name_ = sweep_ ? sweep_->name : build_->config.name;
  output_ = options_.output.empty() ? name_ : options_.output;
  if (build_) conditions_.push_back({.name = name_, .folder = output_, .build = &*build_});
  if (!sweep_) return;
  for (std::size_t v = 0; v < sweep_->builds.size(); ++v) {
    const SweepVariant& variant = sweep_->sweep.variants[v];
    conditions_.push_back({.name = fmt::format("{}", fmt::join(variant.values, ", ")),
                           .folder = output_ / variant.folder,
                           .place = variant.folder,
                           .build = &sweep_->builds[v]});
  }
}

std::filesystem::path EvaluatedDatasets::cache(const Context& context) const {
  if (context.cache.empty() && sweep_) return output_ / "cache";
  return context.cache;
}

int EvaluatedDatasets::build(const Context& context) const {
  if (sweep_) return run_sweep(*sweep_, options_, context);
  return build_ ? run_build(*build_, options_, context) : exit_done;
}

}  // namespace carillon::cli
