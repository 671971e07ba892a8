#include "cli/evaluate/datasets.hpp"

#include <fmt/ranges.h>

#include "cli/sweep/run_sweep.hpp"

namespace carillon::cli {

EvaluatedDatasets::EvaluatedDatasets(const BuildOptions& options, MPI_Comm world)
    : options_(options), sweep_(load_sweep(options, world)) {
  if (!sweep_) build_ = load_build(options, world);
  name_ = sweep_ ? sweep_->name : build_->config.name;
  output_ = options.output.empty() ? name_ : options.output;
  if (build_) conditions_.push_back({name_, output_, &*build_});
  if (!sweep_) return;
  for (std::size_t v = 0; v < sweep_->builds.size(); ++v) {
    const SweepVariant& variant = sweep_->sweep.variants[v];
    conditions_.push_back({fmt::format("{}", fmt::join(variant.values, ", ")),
                           output_ / variant.folder, &sweep_->builds[v]});
  }
}

std::filesystem::path EvaluatedDatasets::cache(const Context& context) const {
  if (context.cache.empty() && sweep_) return output_ / "cache";
  return context.cache;
}

int EvaluatedDatasets::build(const Context& context) const {
  return sweep_ ? run_sweep(*sweep_, options_, context) : run_build(*build_, options_, context);
}

}  // namespace carillon::cli
