#include "eval/studies/learning/learning_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "eval/learning/known_methods.hpp"
#include "eval/learning/read_task.hpp"

namespace carillon::eval::studies {

using core::ConfigNode;
using core::Dimension;

namespace {

constexpr std::int64_t many = 1000000;

template <class T, std::size_t n>
std::vector<std::string> names_of(const T (&all)[n]) {
  std::vector<std::string> names;
  for (const T value : all) names.emplace_back(name_of(value));
  return names;
}

/// The value of a list that a text names; the text is known to be among them.
template <class T, std::size_t n>
T named(const T (&all)[n], const std::string& name) {
  return *std::find_if(all, all + n, [&](T value) { return name_of(value) == name; });
}

/// Some of a list, each at most once.
template <class T, std::size_t n>
std::vector<T> read_some(ConfigNode& node, const std::string& key, const T (&all)[n],
                         const std::vector<T>& fallback) {
  std::vector<std::string> texts;
  for (const T value : fallback) texts.emplace_back(name_of(value));
  texts = node.texts(key, texts);
  const std::vector<std::string> allowed = names_of(all);
  std::vector<T> some;
  for (const std::string& text : texts) {
    if (std::find(allowed.begin(), allowed.end(), text) == allowed.end()) {
      node.fail(key, fmt::format("unknown value \"{}\"", text),
                fmt::format("one or more of {}", fmt::join(allowed, ", ")));
    }
    const T value = named(all, text);
    if (std::find(some.begin(), some.end(), value) != some.end()) {
      node.fail(key, fmt::format("\"{}\" stands here twice", text));
    }
    some.push_back(value);
  }
  if (some.empty()) {
    node.fail(key, "names nothing", fmt::format("one or more of {}", fmt::join(allowed, ", ")));
  }
  return some;
}

void read_steps(ConfigNode& node, learning::LearningOptions& learning) {
  learning.epochs = node.integer("epochs", 1, many, learning.epochs);
  learning.patience = node.integer("patience", 1, many, learning.patience);
  learning.batch = node.integer("batch", 1, many, learning.batch);
  learning.schedule =
      named(learning::all_schedules, node.choice("schedule", names_of(learning::all_schedules),
                                                 std::string(name_of(learning.schedule))));
}

/// Whole numbers of each convolution; pairs of bands and frames where there are two of each.
std::vector<std::vector<double>> read_layer_sizes(ConfigNode& node, const std::string& key,
                                                  std::vector<double> fallback) {
  std::vector<std::vector<double>> sizes;
  if (fallback.size() == 2) {
    sizes = node.rows(key, Dimension::none, 2, fallback);
  } else if (node.is_list(key)) {
    for (const double size : node.quantities(key, Dimension::none)) sizes.push_back({size});
  } else {
    sizes = {{static_cast<double>(
        node.integer(key, 1, many, static_cast<std::int64_t>(fallback.front())))}};
  }
  const double largest = fallback.size() == 2 ? 1024 : static_cast<double>(many);
  for (const std::vector<double>& layer : sizes) {
    for (const double side : layer) {
      if (side >= 1 && side <= largest && side == std::floor(side)) continue;
      node.fail(key, fallback.size() == 2
                         ? "takes two whole numbers, bands and frames, or such a pair for each "
                           "convolution"
                         : "takes a whole number, or one for each convolution");
    }
  }
  if (sizes.empty()) node.fail(key, "is of no convolution", "one value, or one for each of them");
  return sizes;
}

/// A list says how many convolutions there are; what is given once is of each of them.
void read_layers(ConfigNode& node, std::vector<learning::SpectrogramLayer>& layers) {
  const learning::SpectrogramLayer usual;
  const auto number = [](std::int64_t value) { return static_cast<double>(value); };
  const std::pair<const char*, std::vector<std::vector<double>>> given[] = {
      {"filters", read_layer_sizes(node, "filters", {number(usual.filters)})},
      {"kernel",
       read_layer_sizes(node, "kernel", {number(usual.kernel_bands), number(usual.kernel_frames)})},
      {"pooling",
       read_layer_sizes(node, "pooling", {number(usual.pool_bands), number(usual.pool_frames)})}};
  const auto* longest = std::max_element(
      std::begin(given), std::end(given),
      [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
  const std::size_t count = longest->second.size();
  for (const auto& [key, sizes] : given) {
    if (sizes.size() == 1 || sizes.size() == count) continue;
    node.fail(
        key,
        fmt::format("is of {} convolutions, and `{}` of {}", sizes.size(), longest->first, count),
        "as many values, or one for all of them");
  }
  layers.assign(count, usual);
  for (std::size_t i = 0; i < count; ++i) {
    const auto size = [&](std::size_t which, std::size_t side) {
      const auto& sizes = given[which].second;
      return static_cast<std::int64_t>(sizes[sizes.size() == 1 ? 0 : i][side]);
    };
    layers[i] = {.filters = size(0, 0),
                 .kernel_bands = size(1, 0),
                 .kernel_frames = size(1, 1),
                 .pool_bands = size(2, 0),
                 .pool_frames = size(2, 1)};
  }
}

/// Those that the method has; others are no keys of it.
void read_sizes(ConfigNode& node, learning::Method& method) {
  learning::LayerSizes& sizes = method.sizes;
  const auto has = [&](learning::Branch branch) {
    return std::find(method.branches.begin(), method.branches.end(), branch) !=
           method.branches.end();
  };
  sizes.width = node.integer("units", 1, many, sizes.width);
  if (has(learning::Branch::isnn)) {
    read_layers(node, sizes.layers);
  }
  if (!std::all_of(method.branches.begin(), method.branches.end(),
                   [](learning::Branch branch) { return branch == learning::Branch::voxnet; })) {
    sizes.dropout = node.quantity("dropout", Dimension::none, sizes.dropout);
    if (!(sizes.dropout >= 0 && sizes.dropout < 1)) node.fail("dropout", "must lie within 0 and 1");
  }
  if (method.branches.size() > 1 && method.fusion == learning::Fusion::bilinear) {
    sizes.fused = node.integer("fused", 1, many, sizes.fused);
    sizes.factors = node.integer("factors", 1, many, sizes.factors);
  }
}

bool gets_spectrograms(const learning::Method& method) {
  return std::find(method.modalities.begin(), method.modalities.end(),
                   learning::Modality::spectrogram) != method.modalities.end();
}

void read_spectrogram(ConfigNode& node, learning::Method& method) {
  if (!gets_spectrograms(method)) return;
  learning::SpectrogramInput& input = method.spectrogram;
  input.scale = named(learning::all_spectrogram_scales,
                      node.choice("scale", names_of(learning::all_spectrogram_scales),
                                  std::string(learning::name_of(input.scale))));
  if (input.scale == learning::SpectrogramScale::decibels) {
    input.range = node.positive("range", Dimension::level, input.range);
  }
}

learning::Method read_method(ConfigNode& node, const std::string& name,
                             const learning::LearningOptions& common) {
  if (name.find_first_of(".|\"") != std::string::npos) {
    node.fail("", fmt::format("\"{}\" is no name of a method: dots, bars and quotes are kept for "
                              "keys and tables",
                              name));
  }
  const auto known =
      std::find_if(learning::known_methods().begin(), learning::known_methods().end(),
                   [&](const learning::Method& method) { return method.name == name; });
  learning::Method method = known == learning::known_methods().end() ? learning::Method{} : *known;
  const bool is_known = known != learning::known_methods().end();
  method.name = name;
  if (node.has("branches") && node.has("baseline")) {
    node.fail("baseline", "a network with `branches` is no baseline");
  }
  const bool asks = node.has("branches") || node.has("baseline");
  if (!is_known && !asks) {
    node.fail("", fmt::format("no classifier is known by the name \"{}\"", name),
              "say what it is: branches: [isnn, voxnet], or baseline: linear_svm and modalities; "
              "names that are known: carillon list classifiers");
  }
  if (node.has("baseline")) {
    method.kind = named(learning::all_method_kinds,
                        node.choice("baseline", {"nearest_neighbour", "linear_svm"}));
    method.branches.clear();
    method.modalities.clear();
  }
  if (method.kind == learning::MethodKind::network) {
    method.branches = read_some(node, "branches", learning::all_branches, method.branches);
    method.modalities.clear();
    for (const learning::Branch branch : method.branches) {
      method.modalities.push_back(learning::modality_of(branch));
    }
    method.fusion =
        named(learning::all_fusions, node.choice("fusion", names_of(learning::all_fusions),
                                                 std::string(learning::name_of(method.fusion))));
    read_sizes(node, method);
  } else {
    method.modalities = read_some(node, "modalities", learning::all_modalities, method.modalities);
  }
  read_spectrogram(node, method);
  if (method.kind == learning::MethodKind::nearest_neighbour) {
    method.neighbours = node.integer("neighbours", 1, many, method.neighbours);
  }
  if (method.kind == learning::MethodKind::linear_svm) {
    method.cost = node.positive("cost", Dimension::none, method.cost);
  }
  method.learning = common;
  if (method.kind != learning::MethodKind::network) return method;
  read_steps(node, method.learning);
  method.learning.learning_rate =
      node.positive("learning_rate", Dimension::none, method.learning.learning_rate);
  method.learning.weight_decay =
      node.not_negative("weight_decay", Dimension::none, method.learning.weight_decay);
  if (gets_spectrograms(method)) {
    method.learning.equaliser =
        node.not_negative("equaliser", Dimension::level, method.learning.equaliser);
  }
  if (learning::only_hears(method)) {
    method.learning.outliers =
        node.not_negative("outliers", Dimension::none, method.learning.outliers);
  }
  return method;
}

LearningConfig read_learning(ConfigNode& node, const std::string& file) {
  LearningConfig config;
  learning::LearningOptions common;
  common.seed = static_cast<std::uint64_t>(
      node.integer("seed", 0, std::numeric_limits<std::int64_t>::max(), 0));
  read_steps(node, common);
  common.memory = node.positive("memory", Dimension::memory, common.memory);
  common.device = learning::device_named(
      node.choice("device", names_of(learning::all_devices), std::string(name_of(common.device))));
  config.listener = static_cast<std::size_t>(node.integer("listener", 0, many, 0));
  config.join = node.flag("join", false);
  if (node.has("with")) {
    ConfigNode with = node.child("with");
    config.with = read_given(with, with.text("name", "with"), file);
    if (!config.with) with.fail("", "names neither `data` nor `recordings`");
  }
  ConfigNode tasks = node.child("tasks");
  for (const std::string& name : tasks.keys()) {
    ConfigNode task = tasks.child(name);
    config.tasks.push_back(learning::read_task(task, name));
  }
  if (config.tasks.empty()) {
    node.fail("tasks", "names nothing that could be learnt",
              "for example tasks: {geometry: {column: shape}, material: {column: material}}");
  }
  ConfigNode methods = node.child("methods");
  for (const std::string& name : methods.keys()) {
    ConfigNode method = methods.child(name);
    config.methods.push_back(read_method(method, name, common));
  }
  if (config.methods.empty()) {
    node.fail("methods", "names no classifier", "for example methods: {isnn-a: {}}");
  }
  return config;
}

}  // namespace

LearningConfig read_train_section(ConfigNode& root, const std::string& file) {
  if (!root.has("train")) {
    root.fail("train", "says what is learnt by what, and is missing",
              "for example train: {tasks: {material: {column: material}}, methods: {isnn-a: {}}}; "
              "docs/learning.md");
  }
  ConfigNode node = root.child("train");
  LearningConfig config = read_learning(node, file);
  node.finish();
  return config;
}

std::vector<std::uint64_t> read_seeds(ConfigNode& node, const LearningConfig& learning) {
  const auto own = static_cast<double>(learning.methods.front().learning.seed);
  std::vector<std::uint64_t> seeds;
  for (const double value :
       node.quantities("seeds", Dimension::none, 0, std::vector<double>{own})) {
    const auto seed = static_cast<std::uint64_t>(value);
    if (!(value >= 0 && value <= 1e15 && value == static_cast<double>(seed))) {
      node.fail("seeds", fmt::format("{} is no whole number from 0 on", value));
    }
    if (std::find(seeds.begin(), seeds.end(), seed) != seeds.end()) {
      node.fail("seeds", fmt::format("{} stands here twice", seed));
    }
    seeds.push_back(seed);
  }
  if (seeds.empty()) node.fail("seeds", "names no seed", "for example seeds: [1, 2, 3]");
  return seeds;
}

std::vector<learning::Method> with_seeds(const learning::Method& method,
                                         std::span<const std::uint64_t> seeds) {
  std::vector<learning::Method> seeded;
  for (const std::uint64_t seed : seeds) {
    seeded.push_back(method);
    seeded.back().learning.seed = seed;
    if (method.kind == learning::MethodKind::nearest_neighbour) break;
  }
  return seeded;
}

}  // namespace carillon::eval::studies
