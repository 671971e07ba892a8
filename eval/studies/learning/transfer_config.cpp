#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "eval/studies/learning/detail/transfer.hpp"

namespace carillon::eval::studies {

using core::ConfigNode;

namespace {

std::size_t dataset_called(ConfigNode& node, const std::string& key, const std::string& name,
                           const EvaluatedDatasets& datasets) {
  std::vector<std::string> names;
  for (std::size_t c = 0; c < datasets.conditions().size(); ++c) {
    names.push_back(datasets.conditions()[c].name);
    if (names.back() == name) return c;
  }
  node.fail(key, fmt::format("there is no dataset \"{}\"", name),
            fmt::format("there are {}", fmt::join(names, "; ")));
}

std::vector<learning::Method> read_methods(ConfigNode& node, const LearningConfig& learning) {
  std::vector<std::string> known, networks;
  for (const learning::Method& method : learning.methods) {
    known.push_back(method.name);
    if (method.kind == learning::MethodKind::network) networks.push_back(method.name);
  }
  const std::vector<std::string> first = {networks.empty() ? known.front() : networks.front()};
  std::vector<learning::Method> methods;
  for (const std::string& name : node.texts("methods", first)) {
    const auto found = std::find(known.begin(), known.end(), name);
    if (found == known.end()) {
      node.fail("methods", fmt::format("train.methods has no \"{}\"", name));
    }
    methods.push_back(learning.methods[static_cast<std::size_t>(found - known.begin())]);
  }
  return methods;
}

void read_mixes(ConfigNode& node, const EvaluatedDatasets& datasets, TransferSpec& spec) {
  if (!node.has("mixes")) return;
  ConfigNode mixes = node.child("mixes");
  spec.mixed_with = dataset_called(mixes, "mixed_with", mixes.text("mixed_with"), datasets);
  spec.fractions = mixes.quantities("fractions", core::Dimension::none, 0,
                                    std::vector<double>{0, 0.1, 0.3, 0.6, 1});
  for (const double fraction : spec.fractions) {
    if (!(fraction >= 0 && fraction <= 1)) mixes.fail("fractions", "lie within 0 and 1");
  }
  if (spec.fractions.empty()) mixes.fail("fractions", "names no fraction");
}

}  // namespace

TransferSpec read_transfer(ConfigNode& node, ConfigNode& root, const EvaluatedDatasets& datasets) {
  TransferSpec spec;
  spec.learning = read_train_section(root, datasets.config());
  if (spec.learning.join) {
    node.fail("", "`train.join` makes one dataset of all: none is left to be the other condition",
              "--set train.join=false");
  }
  std::vector<std::string> tasks;
  for (const learning::TaskSpec& task : spec.learning.tasks) tasks.push_back(task.name);
  const std::string task = node.choice("task", tasks, tasks.front());
  spec.task = spec.learning.tasks[static_cast<std::size_t>(
      std::find(tasks.begin(), tasks.end(), task) - tasks.begin())];
  spec.methods = read_methods(node, spec.learning);
  spec.seeds = read_seeds(node, spec.learning);
  spec.heard = static_cast<std::size_t>(node.integer("heard", 0, 1000000, 24));
  if (auto given = read_given(node, "target", datasets.config())) {
    spec.target = std::move(*given);
  } else {
    spec.own_target = dataset_called(node, "target_dataset", node.text("target_dataset"), datasets);
    spec.target = datasets.conditions()[*spec.own_target];
  }
  for (std::size_t c = 0; c < datasets.conditions().size(); ++c) {
    if (c != spec.own_target) spec.trained_on.push_back(c);
  }
  read_mixes(node, datasets, spec);
  if (spec.mixed_with && spec.mixed_with == spec.own_target) {
    node.fail("mixes", "the target cannot be mixed with itself");
  }
  if (spec.trained_on.empty()) {
    node.fail("target_dataset", "there is no other dataset to learn from",
              "a sweep makes several; data or recordings take a target from elsewhere");
  }
  const std::size_t usual = spec.mixed_with.value_or(spec.trained_on.front());
  const std::string usual_name = datasets.conditions()[usual].name;
  spec.against = dataset_called(node, "against", node.text("against", usual_name), datasets);
  if (spec.against == spec.own_target) {
    node.fail("against", "what the target's own samples teach is compared anyway (`less_home`)",
              fmt::format("--set evaluate.transfer.against={}", usual_name));
  }
  return spec;
}

}  // namespace carillon::eval::studies
