#include "eval/studies/datasets.hpp"

#include <fmt/ranges.h>

#include <limits>

#include "core/config.hpp"
#include "core/folder_name.hpp"
#include "dataset/run/run_builds.hpp"
#include "dataset/sweep/run_sweep.hpp"
#include "mpi/comm.hpp"
#include "mpi/exit_code.hpp"

namespace carillon::eval::studies {

namespace {

/// A quantity within a range.
double bounded(core::ConfigNode& node, const char* key, core::Dimension dimension, double fallback,
               double minimum, double maximum) {
  const double value = node.quantity(key, dimension, fallback);
  if (!(value >= minimum && value <= maximum)) {
    node.fail(key, fmt::format("must lie within {} and {}", minimum, maximum));
  }
  return value;
}

learning::RecordingsSpec read_recordings(core::ConfigNode node, const std::string& config) {
  learning::RecordingsSpec spec;
  spec.folder = core::path_beside(config, node.text("folder"));
  if (node.has("table") == node.has("names")) {
    node.fail("", "says what the sounds are by one of `table` and `names`",
              "names: \"{material}/{shape}-*.wav\", or table: labels.csv with a column file");
  }
  if (node.has("table")) spec.table = core::path_beside(config, node.text("table"));
  if (node.has("names")) spec.names = node.text("names");
  spec.object = node.text("object_column", "");
  spec.strike = node.text("strike_column", "");
  spec.seconds = bounded(node, "seconds", core::Dimension::time, spec.seconds, 0.01, 60);
  spec.sample_rate =
      bounded(node, "sample_rate", core::Dimension::frequency, spec.sample_rate, 8000, 192000);
  core::ConfigNode split = node.child("split");
  spec.validation = bounded(split, "validation", core::Dimension::none, spec.validation, 0, 1);
  spec.test = bounded(split, "test", core::Dimension::none, spec.test, 0, 1);
  if (spec.validation + spec.test > 1) split.fail("test", "with validation more than all");
  spec.seed = static_cast<std::uint64_t>(
      node.integer("seed", 0, std::numeric_limits<std::int64_t>::max(), 0));
  return spec;
}

/// What a configuration with a key `data` or `recordings` names.
std::optional<Condition> given_condition(const dataset::run::BuildOptions& options,
                                         MPI_Comm world) {
  const std::string text = dataset::run::shared_text(options.config, world);
  std::optional<Condition> given;
  mpi::agreed(world, [&] {
    core::ConfigNode root = core::ConfigNode::parse(text, options.config, options.overrides);
    if (!root.has("data") && !root.has("recordings")) return;
    const std::string name = core::folder_name(root, options.config);
    given = read_given(root, name, options.config);
    root.leave_alone({"train", "search", "evaluate"});
    root.finish();
  });
  return given;
}

}  // namespace

std::optional<Condition> read_given(core::ConfigNode& node, const std::string& name,
                                    const std::string& config) {
  if (node.has("recordings")) {
    const learning::RecordingsSpec spec = read_recordings(node.child("recordings"), config);
    return Condition{.name = name, .folder = spec.folder, .recordings = spec};
  }
  if (!node.has("data")) return std::nullopt;
  const std::filesystem::path folder = core::path_beside(config, node.text("data"));
  if (!std::filesystem::exists(folder / "index.h5")) {
    node.fail("data", fmt::format("{} is no dataset: it has no index.h5", folder.string()),
              "give the folder that carillon build wrote");
  }
  return Condition{.name = name, .folder = folder};
}

EvaluatedDatasets::EvaluatedDatasets(const dataset::run::BuildOptions& options, MPI_Comm world)
    : options_(options) {
  if (auto given = given_condition(options, world)) {
    name_ = given->name;
    output_ = options.output.empty() ? name_ : options.output;
    conditions_.push_back(std::move(*given));
  } else {
    plan(world);
  }
}

void EvaluatedDatasets::plan(MPI_Comm world) {
  sweep_ = dataset::sweep::load_sweep(options_, world);
  if (!sweep_) build_ = dataset::run::load_build(options_, world);
  name_ = sweep_ ? sweep_->name : build_->config.name;
  output_ = options_.output.empty() ? name_ : options_.output;
  if (build_) conditions_.push_back({.name = name_, .folder = output_, .build = &*build_});
  if (!sweep_) return;
  for (std::size_t v = 0; v < sweep_->builds.size(); ++v) {
    const dataset::sweep::SweepVariant& variant = sweep_->sweep.variants[v];
    conditions_.push_back({.name = fmt::format("{}", fmt::join(variant.values, ", ")),
                           .folder = output_ / variant.folder,
                           .place = variant.folder,
                           .build = &sweep_->builds[v]});
  }
}

std::filesystem::path EvaluatedDatasets::cache() const {
  if (options_.cache.empty() && sweep_) return output_ / "cache";
  return options_.cache;
}

int EvaluatedDatasets::build(MPI_Comm world) const {
  if (sweep_) return dataset::sweep::run_sweep(*sweep_, options_, world);
  return build_ ? dataset::run::run_build(*build_, options_, world) : mpi::exit_done;
}

}  // namespace carillon::eval::studies
