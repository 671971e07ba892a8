#include "eval/learning/task.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "core/error.hpp"

namespace carillon::eval::learning {

namespace {

Part part_of(const std::string& text, const SampleSource& source, const std::string& split) {
  if (text == "train") return Part::train;
  if (text == "validation") return Part::validation;
  if (text == "test") return Part::test;
  throw core::InputError(fmt::format("{}: {} says \"{}\" of a sample", source.name(), split, text),
                         "a split is train, validation or test");
}

/// Class of each label.
std::map<std::string, std::string> classes_of(const std::vector<std::string>& labels,
                                              const TaskSpec& task) {
  std::map<std::string, std::string> names;
  if (task.classes.empty()) {
    for (const std::string& label : labels) {
      if (!label.empty()) names[label] = label;
    }
    return names;
  }
  for (const auto& [name, members] : task.classes) {
    for (const std::string& member : members) {
      const auto [at, fresh] = names.emplace(member, name);
      if (!fresh && at->second != name) {
        throw core::InputError(fmt::format("task {}: {} is of two classes, {} and {}", task.name,
                                           member, at->second, name));
      }
    }
  }
  return names;
}

/// Equal names as equal numbers, in the names' order.
std::vector<std::uint32_t> numbered(const std::vector<std::string>& names) {
  std::map<std::string, std::uint32_t> number;
  for (const std::string& name : names) number.emplace(name, 0);
  std::uint32_t next = 0;
  for (auto& [name, own] : number) own = next++;
  std::vector<std::uint32_t> numbers;
  for (const std::string& name : names) numbers.push_back(number.at(name));
  return numbers;
}

/// Which samples have a label that is to be left out.
std::vector<bool> excepted(const SampleSource& source, const TaskSpec& task) {
  std::vector<bool> out(source.size(), false);
  for (const auto& [column, except] : task.except) {
    const std::vector<std::string> labels = source.labels(column);
    for (std::size_t i = 0; i < labels.size(); ++i) {
      if (std::find(except.begin(), except.end(), labels[i]) != except.end()) out[i] = true;
    }
  }
  return out;
}

}  // namespace

nlohmann::json to_json(const TaskSpec& task) {
  return {{"name", task.name},
          {"column", task.column},
          {"split", task.split},
          {"classes", task.classes},
          {"except", task.except}};
}

TaskSpec task_from(const nlohmann::json& json) {
  return {.name = json.at("name"),
          .column = json.at("column"),
          .split = json.at("split"),
          .classes = json.at("classes"),
          .except = json.at("except")};
}

std::vector<std::uint32_t> LabelledSamples::rows(Part wanted) const {
  std::vector<std::uint32_t> rows;
  for (std::size_t i = 0; i < label.size(); ++i) {
    if (label[i] >= 0 && part[i] == wanted) rows.push_back(static_cast<std::uint32_t>(i));
  }
  return rows;
}

LabelledSamples label_samples(const SampleSource& source, const TaskSpec& task) {
  const std::vector<std::string> labels = source.labels(task.column);
  const std::vector<std::string> split = source.labels(task.split);
  const auto class_of = classes_of(labels, task);
  const std::vector<bool> out = excepted(source, task);
  std::set<std::string> found;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const auto at = class_of.find(labels[i]);
    if (at != class_of.end() && !out[i]) found.insert(at->second);
  }
  LabelledSamples samples;
  samples.classes.assign(found.begin(), found.end());
  samples.keys = source.keys();
  samples.object_groups = numbered(source.object_names());
  samples.strike_groups = numbered(source.strike_names());
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const auto at = class_of.find(labels[i]);
    const auto place = at == class_of.end() || out[i] ? found.end() : found.find(at->second);
    samples.label.push_back(place != found.end()
                                ? static_cast<std::int32_t>(std::distance(found.begin(), place))
                            : labels[i].empty() ? unlabelled
                                                : left_out);
    samples.part.push_back(part_of(split[i], source, task.split));
  }
  return samples;
}

void require_learnable(const LabelledSamples& samples, const SampleSource& source,
                       const TaskSpec& task) {
  for (const auto& [column, except] : task.except) {
    const std::vector<std::string> labels = source.labels(column);
    for (const std::string& label : except) {
      if (std::find(labels.begin(), labels.end(), label) != labels.end()) continue;
      throw core::InputError(
          fmt::format("task {}: there is no {} to leave out in {}", task.name, label, column),
          fmt::format("there are {}", fmt::join(std::set(labels.begin(), labels.end()), ", ")));
    }
  }
  if (samples.classes.size() < 2) {
    throw core::InputError(fmt::format(
        "{}: task {} has {} of {}: nothing is to be told from anything", source.name(), task.name,
        samples.classes.empty() ? "no class" : fmt::format("one class, {},", samples.classes[0]),
        task.column));
  }
  if (samples.rows(Part::train).empty()) {
    throw core::InputError(
        fmt::format("{}: task {}: {} holds no sample to train with", source.name(), task.name,
                    task.split),
        "more objects or strikes, or another split column: split_strike where classes are shapes");
  }
}

std::vector<std::string> remarks(const LabelledSamples& samples) {
  std::vector<std::vector<std::string>> without(3);
  for (std::size_t c = 0; c < samples.classes.size(); ++c) {
    bool there[3] = {false, false, false};
    for (std::size_t i = 0; i < samples.label.size(); ++i) {
      if (samples.label[i] == static_cast<std::int32_t>(c)) {
        there[static_cast<std::size_t>(samples.part[i])] = true;
      }
    }
    for (std::size_t p = 0; p < 3; ++p) {
      if (!there[p]) without[p].push_back(samples.classes[c]);
    }
  }
  std::vector<std::string> texts;
  if (!without[0].empty()) {
    texts.push_back(
        fmt::format("nothing is learnt of {}: no sample in train", fmt::join(without[0], ", ")));
  }
  if (!without[2].empty()) {
    texts.push_back(fmt::format("{} not tested: no sample in test", fmt::join(without[2], ", ")));
  }
  if (samples.rows(Part::validation).empty()) {
    texts.push_back("no sample in validation: training stops after its last epoch alone");
  }
  return texts;
}

}  // namespace carillon::eval::learning
