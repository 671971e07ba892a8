#include "eval/studies/learning/search.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/config.hpp"
#include "core/progress.hpp"
#include "eval/studies/learning/run_trainings.hpp"

namespace carillon::eval::studies {

using core::ConfigNode;
using nlohmann::ordered_json;

namespace {

/// Trials that a person sees of a search.
constexpr std::size_t shown = 8;

const learning::Method* method_called(const LearningConfig& config, const std::string& name) {
  const auto found = std::find_if(config.methods.begin(), config.methods.end(),
                                  [&](const learning::Method& one) { return one.name == name; });
  return found == config.methods.end() ? nullptr : &*found;
}

Search read_search(const std::string& text, const dataset::run::BuildOptions& options,
                   ConfigNode& searches, const std::string& method) {
  ConfigNode root = ConfigNode::parse(text, options.config, options.overrides);
  const LearningConfig config = read_train_section(root, options.config);
  if (method_called(config, method) == nullptr) {
    searches.fail(method, fmt::format("train.methods has no \"{}\"", method));
  }
  Search search;
  std::vector<std::string> tasks;
  for (const learning::TaskSpec& task : config.tasks) tasks.push_back(task.name);
  const std::string task = searches.child(method).choice("task", tasks, tasks.front());
  search.task = config.tasks[static_cast<std::size_t>(std::find(tasks.begin(), tasks.end(), task) -
                                                      tasks.begin())];
  const std::string prefix = fmt::format("train.methods.{}.", method);
  const auto sweep = dataset::sweep::read_sweep(
      text, options.config, options.overrides,
      {.path = {"search", method}, .prefix = prefix, .others = {"task"}});
  if (!sweep) searches.fail(method, "names no keys", "for example {keys: {filters: [8, 16]}}");
  for (const std::string& key : sweep->keys) search.keys.push_back(key.substr(prefix.size()));
  for (const dataset::sweep::SweepVariant& variant : sweep->variants) {
    std::vector<std::string> overrides = options.overrides;
    overrides.insert(overrides.end(), variant.overrides.begin(), variant.overrides.end());
    ConfigNode changed = ConfigNode::parse(text, options.config, overrides);
    const LearningConfig read = read_train_section(changed, options.config);
    search.trials.push_back({variant.values, *method_called(read, method)});
  }
  return search;
}

ordered_json trial_line(const Search& search, const SearchTrial& trial, const JobEnd& end) {
  ordered_json line = {{"values", ordered_json::object()}};
  for (std::size_t k = 0; k < search.keys.size(); ++k) {
    line["values"][search.keys[k]] = trial.values[k];
  }
  for (const char* name : {"validation_accuracy", "validation_loss", "parameters", "epochs"}) {
    line[name] = end.found.value(name, ordered_json());
  }
  line["seconds"] = end.found.at("timing").at("seconds");
  line["was_there"] = end.was_there;
  return line;
}

/// Higher accuracy first, then lower loss; what has none last.
bool is_better(const ordered_json& a, const ordered_json& b) {
  const auto number = [](const ordered_json& value, double without) {
    return value.is_number() ? value.get<double>() : without;
  };
  const double first = number(a.at("validation_accuracy"), -1);
  const double second = number(b.at("validation_accuracy"), -1);
  if (first != second) return first > second;
  return number(a.at("validation_loss"), 1e300) < number(b.at("validation_loss"), 1e300);
}

}  // namespace

std::vector<Search> read_searches(const std::string& text,
                                  const dataset::run::BuildOptions& options) {
  ConfigNode root = ConfigNode::parse(text, options.config, options.overrides);
  if (!root.has("search")) {
    root.fail(
        "search", "says which sizes are tried, and is missing",
        "for example search: {isnn-a: {mode: random, count: 20, keys: {filters: [8, 16, 32]}}}; "
        "docs/learning.md");
  }
  ConfigNode searches = root.child("search");
  std::vector<Search> read;
  for (const std::string& method : searches.keys()) {
    read.push_back(read_search(text, options, searches, method));
  }
  if (read.empty()) root.fail("search", "names no method");
  return read;
}

ordered_json run_searches(const std::vector<Search>& searches, const LearningConfig& config,
                          const EvaluatedDatasets& datasets, const mpi::Context& context) {
  const std::filesystem::path models = datasets.output() / "evaluation" / "searched";
  const auto sources = open_learning_sources(config, datasets, context);
  const LearningSource& source = sources.front();
  ordered_json document = ordered_json::array();
  for (const Search& search : searches) {
    const std::string& method = search.trials.front().method.name;
    std::vector<ordered_json> lines;
    for (std::size_t t = 0; t < search.trials.size(); ++t) {
      TrainingJob job = make_job(*source.samples, search.task, search.trials[t].method, models);
      job.key = fmt::format("{}/{} {}/{}", search.task.name, method, t + 1, search.trials.size());
      job.is_for_use = false;
      const JobEnd end = run_job(job, *source.samples, context);
      if (end.interrupted) return nullptr;
      lines.push_back(trial_line(search, search.trials[t], end));
    }
    std::stable_sort(lines.begin(), lines.end(), is_better);
    document.push_back({{"method", method},
                        {"task", search.task.name},
                        {"dataset", source.name},
                        {"trials", lines}});
  }
  return document;
}

std::string search_text(const ordered_json& document) {
  std::string text;
  for (const ordered_json& search : document) {
    text += fmt::format(
        "{} on {} of {}, by the validation samples:\n", search.at("method").get<std::string>(),
        search.at("task").get<std::string>(), search.at("dataset").get<std::string>());
    const ordered_json& trials = search.at("trials");
    std::vector<std::string> recorded;
    for (std::size_t t = 0; t < std::min(shown, trials.size()); ++t) {
      const ordered_json& trial = trials[t];
      std::vector<std::string> values;
      for (const auto& [key, value] : trial.at("values").items()) {
        values.push_back(fmt::format("{}: {}", key, value.get<std::string>()));
      }
      if (t == 0) recorded = values;
      const ordered_json& accuracy = trial.at("validation_accuracy");
      const ordered_json& loss = trial.at("validation_loss");
      text += fmt::format(
          "  {:>7} %  loss {:>7}  {:>9} numbers  {:>8}  {}\n",
          accuracy.is_null() ? "-" : fmt::format("{:.2f}", 100 * accuracy.get<double>()),
          loss.is_null() ? "-" : fmt::format("{:.4f}", loss.get<double>()),
          trial.at("parameters").is_null() ? 0 : trial.at("parameters").get<std::int64_t>(),
          core::human_duration(trial.at("seconds")), fmt::join(values, ", "));
    }
    if (trials.size() > shown) text += fmt::format("  and {} more\n", trials.size() - shown);
    text += fmt::format("train.methods.{}, beside its other keys: {}\n\n",
                        search.at("method").get<std::string>(), fmt::join(recorded, ", "));
  }
  return text;
}

}  // namespace carillon::eval::studies
