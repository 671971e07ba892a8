#include "eval/learning/read_task.hpp"

namespace carillon::eval::learning {

using core::ConfigNode;

namespace {

/// Labels to leave out: of the task's column, or of others.
std::map<std::string, std::vector<std::string>> read_except(ConfigNode& node,
                                                            const std::string& column) {
  if (!node.has("except")) return {};
  if (!node.is_mapping("except")) return {{column, node.texts("except")}};
  ConfigNode except = node.child("except");
  std::map<std::string, std::vector<std::string>> labels;
  for (const std::string& other : except.keys()) labels[other] = except.texts(other);
  return labels;
}

}  // namespace

TaskSpec read_task(ConfigNode& node, const std::string& name) {
  TaskSpec task;
  task.name = name;
  task.column = node.text("column");
  task.split = node.choice("split_column", {"split_shape", "split_strike"},
                           task.column == "shape" ? "split_strike" : "split_shape");
  if (task.column == "shape" && task.split == "split_shape") {
    node.fail("split_column",
              "whole shapes are held out: none that is tested could have been learnt",
              "split_strike holds out strikes of each shape");
  }
  task.except = read_except(node, task.column);
  if (node.has("label_groups")) {
    if (task.except.count(task.column) > 0) {
      node.fail("except", "labels that stand in none of `label_groups` are left out already");
    }
    ConfigNode classes = node.child("label_groups");
    for (const std::string& label : classes.keys()) task.classes[label] = classes.texts(label);
  }
  return task;
}

}  // namespace carillon::eval::learning
