#include "eval/studies/learning/search.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "core/config.hpp"
#include "core/json.hpp"
#include "core/progress.hpp"
#include "core/random.hpp"
#include "eval/scoring/tables.hpp"
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

/// Every value is tried with the first ones of other keys, so that one that the method refuses is
/// told before anything is trained.
SequentialTrials sequential_trials(
    const dataset::sweep::Sweep& sweep,
    std::function<SearchTrial(const statistics::ParzenPoint&)> trial_at) {
  SequentialTrials trials{static_cast<std::size_t>(sweep.count), sweep.seed, {}, {}};
  for (const dataset::sweep::SweepAxis& axis : sweep.axes) {
    trials.axes.push_back({axis.values.size()});
  }
  for (std::size_t a = 0; a < trials.axes.size(); ++a) {
    for (std::size_t i = 0; i < std::max<std::size_t>(2, trials.axes[a].choices); ++i) {
      if (i > 0 && i == trials.axes[a].choices) break;  // the only value
      statistics::ParzenPoint point(trials.axes.size(), 0.0);
      point[a] = static_cast<double>(i);
      trial_at(point);
    }
  }
  trials.trial_at = std::move(trial_at);
  return trials;
}

Search read_search(const std::string& text, const dataset::run::BuildOptions& options,
                   ConfigNode& searches, const std::string& method) {
  ConfigNode root = ConfigNode::parse(text, options.config, options.overrides);
  const LearningConfig config = read_train_section(root, options.config);
  if (method_called(config, method) == nullptr) {
    searches.fail(method, fmt::format("train.methods has no \"{}\"", method));
  }
  Search search;
  search.method = method;
  std::vector<std::string> tasks;
  for (const learning::TaskSpec& task : config.tasks) tasks.push_back(task.name);
  const std::string task = searches.child(method).choice("task", tasks, tasks.front());
  search.task = config.tasks[static_cast<std::size_t>(std::find(tasks.begin(), tasks.end(), task) -
                                                      tasks.begin())];
  const std::string prefix = fmt::format("train.methods.{}.", method);
  const auto sweep = dataset::sweep::read_sweep(
      text, options.config, options.overrides,
      {.path = {"search", method}, .prefix = prefix, .others = {"task"}, .is_search = true});
  if (!sweep) searches.fail(method, "names no keys", "for example {keys: {filters: [8, 16]}}");
  for (const std::string& key : sweep->keys) search.keys.push_back(key.substr(prefix.size()));
  const auto trial_of = [text, options, method](const dataset::sweep::SweepVariant& variant) {
    std::vector<std::string> overrides = options.overrides;
    overrides.insert(overrides.end(), variant.overrides.begin(), variant.overrides.end());
    ConfigNode changed = ConfigNode::parse(text, options.config, overrides);
    const LearningConfig read = read_train_section(changed, options.config);
    return SearchTrial{variant.values, *method_called(read, method)};
  };
  for (const dataset::sweep::SweepVariant& variant : sweep->variants) {
    search.trials.push_back(trial_of(variant));
  }
  if (sweep->mode == "parzen") {
    search.sequential = sequential_trials(*sweep, [sweep, trial_of](const auto& point) {
      return trial_of(dataset::sweep::variant_at(*sweep, point));
    });
  }
  return search;
}

/// What is tried, one after the other.
class TrialQueue {
 public:
  explicit TrialQueue(const Search& search)
      : search_(search),
        random_(search.sequential ? search.sequential->seed : 0, core::stable_hash(search.method),
                "search") {}

  std::size_t count() const {
    return search_.sequential ? search_.sequential->count : search_.trials.size();
  }
  /// @param best_first  numbers of the trials so far, the best first
  std::optional<SearchTrial> next(const std::vector<std::size_t>& best_first) {
    if (!search_.sequential) {
      if (number_ == search_.trials.size()) return {};
      return search_.trials[number_++];
    }
    if (points_.size() == count()) return {};
    std::vector<statistics::ParzenPoint> ordered;
    for (const std::size_t trial : best_first) ordered.push_back(points_[trial]);
    const auto point = statistics::next_parzen_point(search_.sequential->axes, ordered, random_);
    if (!point) return {};  // all were tried
    points_.push_back(*point);
    return search_.sequential->trial_at(*point);
  }

 private:
  const Search& search_;
  core::RandomStream random_;
  std::size_t number_ = 0;
  std::vector<statistics::ParzenPoint> points_;
};

/// Higher accuracy first, then lower loss; what has none last.
bool is_better(const SearchFindings::Trial& a, const SearchFindings::Trial& b) {
  const auto rank = [](const TrainingRecord& record) {
    const double loss = record.learnt ? record.learnt->validation_loss : core::nan;
    return std::pair(std::isnan(record.validation_accuracy) ? 1 : -record.validation_accuracy,
                     std::isnan(loss) ? core::infinity : loss);
  };
  return rank(a.record) < rank(b.record);
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

std::optional<std::vector<SearchFindings>> run_searches(const std::vector<Search>& searches,
                                                        const LearningConfig& config,
                                                        const EvaluatedDatasets& datasets,
                                                        MPI_Comm world) {
  const std::filesystem::path models = datasets.output() / "evaluation" / "searched";
  const auto sources = open_learning_sources(config, datasets, world);
  const LearningSource& source = sources.front();
  std::vector<SearchFindings> all;
  for (const Search& search : searches) {
    std::vector<SearchFindings::Trial> trials;
    std::vector<std::size_t> best_first;
    TrialQueue queue(search);
    while (const std::optional<SearchTrial> trial = queue.next(best_first)) {
      TrainingJob job = make_job(*source.samples, search.task, trial->method, models);
      job.key = fmt::format("{}/{} {}/{}", search.task.name, search.method, trials.size() + 1,
                            queue.count());
      job.is_for_use = false;
      JobEnd end = run_job(job, *source.samples, world);
      if (end.interrupted) return std::nullopt;
      trials.push_back({trial->values, std::move(end.record), end.was_there});
      best_first.insert(
          std::find_if(best_first.begin(), best_first.end(),
                       [&](std::size_t other) { return is_better(trials.back(), trials[other]); }),
          trials.size() - 1);
    }
    SearchFindings& found = all.emplace_back(
        SearchFindings{search.method, search.task.name, source.name, search.keys, {}});
    for (const std::size_t t : best_first) found.trials.push_back(std::move(trials[t]));
  }
  return all;
}

ordered_json to_json(const std::vector<SearchFindings>& searches) {
  ordered_json document = ordered_json::array();
  for (const SearchFindings& search : searches) {
    ordered_json lines = ordered_json::array();
    for (const auto& [values, record, was_there] : search.trials) {
      ordered_json line = {
          {"values", ordered_json::object()},
          {"validation_accuracy", core::number_or_null(record.validation_accuracy)},
          {"validation_loss", nullptr},
          {"parameters", nullptr},
          {"epochs", nullptr},
          {"seconds", record.seconds},
          {"was_there", was_there}};
      for (std::size_t k = 0; k < values.size(); ++k) line["values"][search.keys[k]] = values[k];
      if (record.learnt) {
        line["validation_loss"] = core::number_or_null(record.learnt->validation_loss);
        line["parameters"] = record.learnt->parameters;
        line["epochs"] = record.learnt->epochs;
      }
      lines.push_back(std::move(line));
    }
    document.push_back({{"method", search.method},
                        {"task", search.task},
                        {"dataset", search.dataset},
                        {"trials", std::move(lines)}});
  }
  return document;
}

std::string to_text(const std::vector<SearchFindings>& searches) {
  std::string text;
  for (const SearchFindings& search : searches) {
    text += fmt::format("{} on {} of {}, by the validation samples:\n", search.method, search.task,
                        search.dataset);
    const auto settings = [&](const SearchFindings::Trial& trial) {
      std::vector<std::string> values;
      for (std::size_t k = 0; k < trial.values.size(); ++k) {
        values.push_back(fmt::format("{}: {}", search.keys[k], trial.values[k]));
      }
      return fmt::format("{}", fmt::join(values, ", "));
    };
    for (std::size_t t = 0; t < std::min(shown, search.trials.size()); ++t) {
      const TrainingRecord& record = search.trials[t].record;
      const TrainingRecord::Learnt learnt = record.learnt.value_or(TrainingRecord::Learnt{});
      text += fmt::format("  {:>7} %  loss {:>7}  {:>9} numbers  {:>8}  {}\n",
                          scoring::percent(record.validation_accuracy),
                          scoring::figure(learnt.validation_loss, 4), learnt.parameters,
                          core::human_duration(record.seconds), settings(search.trials[t]));
    }
    if (search.trials.size() > shown) {
      text += fmt::format("  and {} more\n", search.trials.size() - shown);
    }
    text += fmt::format("train.methods.{}, beside its other keys: {}\n\n", search.method,
                        settings(search.trials.front()));
  }
  return text;
}

}  // namespace carillon::eval::studies
